#include "tests/tess/slots.hpp"

#include <fmt/format.h>

namespace tessera::test {

namespace {
constexpr std::uint32_t kFree = 0xffffffffu;
}

TexelList lTexelList(std::uint32_t level) {
  const std::uint32_t side = level + 1;
  std::vector<bool> written(std::size_t{side} * side, false);
  const auto write = [&](const glsl::TessPlace& place) {
    const glsl::LTexels texels = glsl::lTexelsOf(place, level);
    written[texels.first.y * std::size_t{side} + texels.first.x] = true;
    written[texels.second.y * std::size_t{side} + texels.second.x] = true;
  };
  for (std::uint32_t ring = 0; 2 * ring < level; ++ring)
    for (std::uint32_t edge = 0; edge < 3; ++edge)
      for (std::uint32_t step = 0; step < level - 2 * ring; ++step) write({ring, edge, step});
  if (level % 2 == 0) write({level / 2, 0, 0});
  TexelList list;
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x)
      if (written[y * std::size_t{side} + x]) list.emplace_back(x, y);
  return list;
}

TexelList blockTexelList(std::uint32_t columns, std::uint32_t rows) {
  TexelList list;
  const auto cellTouches = [&](std::int64_t x, std::int64_t y) {
    return x >= 0 && y >= 0 && x + 1 < columns && y + 1 < rows &&
           x * (rows - 1) + y * (columns - 1) < std::int64_t{columns - 1} * (rows - 1);
  };
  for (std::int64_t y = 0; y < rows; ++y)
    for (std::int64_t x = 0; x < columns; ++x)
      if (rows == 1 || cellTouches(x, y) || cellTouches(x - 1, y) || cellTouches(x, y - 1) ||
          cellTouches(x - 1, y - 1))
        list.emplace_back(x, y);
  return list;
}

const TexelList& SlotPainter::listOf(std::uint32_t bin) {
  const auto [found, fresh] = lists_.try_emplace(bin);
  if (fresh) {
    const glm::uvec2 block =
        bin < glsl::kLargestLevel ? glm::uvec2(0) : glsl::overBinBlock(bin - glsl::kLargestLevel);
    found->second = bin < glsl::kLargestLevel ? lTexelList(bin + 1) : blockTexelList(block.x, block.y);
  }
  return found->second;
}

std::string SlotPainter::paintTexel(std::uint32_t owner, std::uint32_t x, std::uint32_t y) {
  std::uint32_t& now = owners_[y * static_cast<std::size_t>(width_) + x];
  if (now != 0)
    return fmt::format("texel ({}, {}) of {} is {}'s already", x, y, static_cast<int>(owner) - 1,
                       static_cast<int>(now) - 1);
  now = owner;
  return {};
}

std::string SlotPainter::paintSlot(std::uint32_t triangle, std::uint32_t bin, std::uint32_t place,
                                   const TexelList& texels, const glsl::TessBin& cell,
                                   const glsl::TessAtlasState& state) {
  const std::uint32_t left = glsl::placeX(place);
  const std::uint32_t top = glsl::placeY(place);
  if (left + cell.cellWidth > state.config.width || top + cell.cellHeight > state.config.height)
    return fmt::format("triangle {}: cell of {} x {} at ({}, {}) leaves the atlas", triangle, cell.cellWidth,
                       cell.cellHeight, left, top);
  ++held_[bin];
  for (const glm::uvec2 at : texels) {
    if (at.x >= cell.cellWidth || at.y >= cell.cellHeight)
      return fmt::format("triangle {}: texel ({}, {}) is outside of its cell", triangle, at.x, at.y);
    const bool turned = glsl::placeTurned(place) != 0;
    if (auto wrong = paintTexel(triangle + 1, left + (turned ? cell.cellWidth - 1 - at.x : at.x),
                                top + (turned ? cell.cellHeight - 1 - at.y : at.y));
        !wrong.empty())
      return wrong;
  }
  return {};
}

std::string SlotPainter::paint(std::span<const std::uint32_t> visible, const glsl::TessAtlasState& state,
                               const std::vector<glsl::TessState>& states,
                               const std::vector<glsl::TessBin>& bins) {
  owners_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
  held_.assign(bins.size(), 0);
  for (const std::uint32_t triangle : visible) {
    const glsl::TessState& now = states[triangle];
    const std::uint32_t kind = glsl::kindOf(now.shape.kind);
    std::string wrong;
    if (kind == glsl::kTessSingle) {
      const std::uint32_t x = triangle % state.config.width;
      const std::uint32_t y = state.config.height + triangle / state.config.width;
      if (glsl::placeX(now.place0) != x || glsl::placeY(now.place0) != y)
        return fmt::format("triangle {}: its one texel is at ({}, {})", triangle, glsl::placeX(now.place0),
                           glsl::placeY(now.place0));
      wrong = paintTexel(triangle + 1, x, y);
    } else if (kind == glsl::kTessL) {
      const std::uint32_t bin = glsl::levelOfKind(now.shape.kind) - 1;
      wrong = paintSlot(triangle, bin, now.place0, listOf(bin), bins[bin], state);
    } else if (kind == glsl::kTessOver) {
      const glsl::OverShape over = glsl::overOfShape(now.shape);
      for (std::uint32_t half = 0; half < 2 && wrong.empty(); ++half) {
        const std::uint32_t columns = half == 0 ? over.columns0 : over.columns1;
        if (columns == 0) continue;
        const std::uint32_t bin = glsl::kLargestLevel + glsl::overBin(columns, over.rows);
        wrong = paintSlot(triangle, bin, half == 0 ? now.place0 : now.place1, listOf(bin), bins[bin], state);
      }
    } else {
      return fmt::format("triangle {} has no place", triangle);
    }
    if (!wrong.empty()) return wrong;
  }
  for (std::uint32_t r = 0; r < state.rectCount; ++r) {
    const glsl::FreeRect& rect = state.rects[r];
    if (rect.x + rect.width > state.config.width || rect.y + rect.height > state.config.height)
      return fmt::format("free rectangle {} leaves the atlas", r);
    for (std::uint32_t y = rect.y; y < rect.y + rect.height; ++y)
      for (std::uint32_t x = rect.x; x < rect.x + rect.width; ++x)
        if (auto wrong = paintTexel(kFree, x, y); !wrong.empty())
          return fmt::format("free rectangle {}: {}", r, wrong);
  }
  return {};
}

}  // namespace tessera::test
