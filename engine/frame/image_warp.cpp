#include "engine/frame/image_warp.hpp"

#include <glm/gtc/type_ptr.hpp>

#include "engine/gl/draw_state.hpp"
#include "glsl/shared/bindings.h"

namespace tessera {

namespace {

const char* nameOf(Warp warp) {
  return warp == Warp::Time   ? "time warping"
         : warp == Warp::Mesh ? "mesh warping"
                              : "iterative image warping";
}

Result<void> check(Warp warp, const WarpSource& source, const View& to, const WarpOptions& options) {
  const auto fits = [&](const gl::Texture* texture) {
    return texture != nullptr && *texture && texture->width() == source.view.width &&
           texture->height() == source.view.height;
  };
  if (!fits(source.encoded) || (warp != Warp::Time && !fits(source.depth)))
    return fail("{}: no picture of {} x {}{} is there", nameOf(warp), source.view.width, source.view.height,
                warp == Warp::Time ? "" : " with depth");
  if (to.width < 1 || to.height < 1)
    return fail("{}: to a picture of {} x {}", nameOf(warp), to.width, to.height);
  if (options.starts < 1 || options.starts > 64)
    return fail("{}: {} starts are outside [1, 64]", nameOf(warp), options.starts);
  if (options.iterations < 1 || options.iterations > 64)
    return fail("{}: {} iterations are outside [1, 64]", nameOf(warp), options.iterations);
  if (!(options.converged > 0.0f && options.converged <= 16.0f))
    return fail("{}: converged within {} pixels is outside (0, 16]", nameOf(warp), options.converged);
  return {};
}

void setVec4(const gl::Program& program, GLint location, const glm::vec4& value) {
  gl::api().ProgramUniform4fv(program.get(), location, 1, &value.x);
}

}  // namespace

Result<ImageWarp> ImageWarp::create(gl::ProgramCache& programs, std::span<const Warp> wanted) {
  ImageWarp made;
  for (const Warp warp : wanted) {
    Result<void> compiled;
    // Depth of no picture: a triangle over all of it.
    const std::string all = "pass/streamed_far.vert";
    const auto take = [&](const gl::Program*& into, const std::vector<std::string>& paths) {
      auto program = programs.get(paths);
      if (!program && compiled) compiled = tl::unexpected(program.error());
      if (program) into = *program;
    };
    if (warp == Warp::Time) take(made.time_, {all, "pass/warp_time.frag"});
    if (warp == Warp::Mesh) take(made.mesh_, {"pass/warp_mesh.vert", "pass/warp_mesh.frag"});
    if (warp == Warp::Iterative) {
      take(made.iterative_, {all, "pass/warp_iterative.frag"});
      take(made.findNearest_, {"pass/warp_nearest.comp"});
      made.nearest_ = gl::Buffer(sizeof(std::uint32_t));
    }
    if (!compiled) return tl::unexpected(compiled.error());
  }
  made.noVertices_ = gl::VertexArray::make();
  return made;
}

Result<void> ImageWarp::draw(Warp warp, const WarpSource& source, const View& to,
                             const gl::Framebuffer& target, const glm::vec4& background,
                             const WarpOptions& options) {
  if (auto good = check(warp, source, to, options); !good) return good;
  const gl::Program* program = warp == Warp::Time ? time_ : warp == Warp::Mesh ? mesh_ : iterative_;
  if (program == nullptr) return fail("{}: its programs were not compiled", nameOf(warp));
  source.encoded->bind(UNIT_PICTURE);
  if (source.depth != nullptr) source.depth->bind(UNIT_DEPTH);
  if (warp == Warp::Iterative) {
    nearest_.fill(0);
    nearest_.bindStorage(BIND_WARP_NEAREST);
    findNearest_->use();
    gl::dispatchOver(source.view.width, source.view.height, 16);
    gl::api().MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  }
  gl::api().BindFramebuffer(GL_FRAMEBUFFER, target.get());
  gl::api().Viewport(0, 0, to.width, to.height);
  gl::apply({.depth = gl::DepthTest::GreaterEqual, .depthWrite = true});
  const float farthest = 0.0f;
  gl::api().ClearNamedFramebufferfv(target.get(), GL_COLOR, 0, &background.x);
  gl::api().ClearNamedFramebufferfv(target.get(), GL_DEPTH, 0, &farthest);
  gl::api().BindVertexArray(noVertices_.get());
  if (warp == Warp::Mesh) {
    drawMesh(source, to);
  } else {
    setVec4(*program, LOCATION_BACKGROUND, background);
    drawPixels(*program, warp, source, to, options);
  }
  return {};
}

void ImageWarp::drawMesh(const WarpSource& source, const View& to) {
  const View& from = source.view;
  const glm::dmat4 toClip = viewProjection(to, from.eye);
  const glm::dmat3 rays = pixelToRay(from);
  glm::dmat4 columns(0.0);
  for (int i = 0; i < 3; ++i) columns[i] = toClip * glm::dvec4(rays[i], 0.0);
  columns[3] = toClip * glm::dvec4(0.0, 0.0, 0.0, 1.0 / from.zNear);
  const glm::mat4 placeToClip(columns);
  mesh_->use();
  gl::api().ProgramUniformMatrix4fv(mesh_->get(), LOCATION_VIEW, 1, GL_FALSE, glm::value_ptr(placeToClip));
  gl::api().DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 2 * (from.width + 2), from.height + 1);
}

void ImageWarp::drawPixels(const gl::Program& program, Warp warp, const WarpSource& source, const View& to,
                           const WarpOptions& options) {
  const View& from = source.view;
  // A ray of a picture is its pixelToRay times (1, x, y): so the inverse gives (w, x w, y w) of any
  // direction. In double, and of the difference of both eyes alone, however far out they are.
  const glm::dmat3 rays = pixelToRay(from);
  const glm::dmat3 toPlace = glm::inverse(rays);
  const glm::mat3 toSource(toPlace * pixelToRay(to));
  program.use();
  gl::api().ProgramUniformMatrix3fv(program.get(), LOCATION_WARP, 1, GL_FALSE, glm::value_ptr(toSource));
  if (warp == Warp::Iterative) {
    const glm::dvec3 moved = to.eye - from.eye;
    const glm::vec3 eye(toPlace * moved / from.zNear);
    const glm::dvec3 ahead = glm::transpose(rays) * to.forward * (from.zNear / to.zNear);
    const glm::vec3 search(options.starts, options.iterations, options.converged);
    gl::api().ProgramUniform3fv(program.get(), LOCATION_WARP_EYE, 1, &eye.x);
    setVec4(program, LOCATION_WARP_DEPTH,
            glm::vec4(glm::dvec4(ahead, -glm::dot(moved, to.forward) / to.zNear)));
    gl::api().ProgramUniform3fv(program.get(), LOCATION_SIZE, 1, &search.x);
  }
  gl::api().DrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace tessera
