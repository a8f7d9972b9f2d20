#include "atlas/gatherer.hpp"

#include <array>

namespace tessera {

namespace {

GLenum glFormatOf(AtlasFormat format) {
  switch (format) {
    case AtlasFormat::Rgba16f:
      return GL_RGBA16F;
    case AtlasFormat::Rgb10a2:
      return GL_RGB10_A2;
    case AtlasFormat::R11g11b10f:
      return GL_R11F_G11F_B10F;
    default:
      return GL_SRGB8_ALPHA8;
  }
}

}  // namespace

Result<AtlasTexture> AtlasTexture::create(int width, int height, AtlasFormat format) {
  GLint largest = 0;
  gl::api().GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (width > largest || height > largest)
    return fail("atlas of {} x {} texels (with the rows of single texels) is past this context's limit of {}",
                width, height, largest);
  AtlasTexture atlas;
  atlas.format = format;
  atlas.texture = gl::Texture(glFormatOf(format), width, height);
  if (format == AtlasFormat::Srgb8) atlas.encoded = atlas.texture.view(GL_RGBA8);
  for (gl::Texture* texture : {&atlas.texture, &atlas.encoded}) {
    if (!*texture) continue;
    texture->filter(GL_LINEAR, GL_LINEAR);
    texture->wrap(GL_CLAMP_TO_EDGE);
  }
  gl::api().ClearTexImage(atlas.texture.get(), 0, GL_RGBA, GL_FLOAT, nullptr);
  const std::array<const gl::Texture*, 1> colors = {&atlas.texture};
  atlas.framebuffer = gl::Framebuffer(colors);
  const std::array<const gl::Texture*, 1> raw = {&atlas.encoded};
  if (atlas.encoded) atlas.encodedFramebuffer = gl::Framebuffer(raw);
  return atlas;
}

GatherStatistics Gatherer::readStatistics() const {
  GatherStatistics statistics;
  statistics.samples = readSamples();
  statistics.kinds = {{"texels", {150, 160, 170}, statistics.samples}};
  return statistics;
}

void Gatherer::beginShading() const {
  const AtlasTexture& target = atlas();
  gl::api().BindFramebuffer(
      GL_FRAMEBUFFER,
      (encodes() && target.encodedFramebuffer ? target.encodedFramebuffer : target.framebuffer).get());
  gl::api().Viewport(0, 0, target.texture.width(), target.texture.height());
}

}  // namespace tessera
