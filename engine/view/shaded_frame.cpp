#include "engine/view/shaded_frame.hpp"

namespace tessera::view {

namespace {

template <class T>
void copy(std::vector<T>& to, std::span<const T> from) {
  to.assign(from.begin(), from.end());
}

}  // namespace

void ShadedFrame::take(const wire::VisibleMirror& mirror) {
  method = mirror.method();
  copy(vertices, mirror.vertices());
  if (masks->empty())
    maskAt.clear();
  else
    copy(maskAt, mirror.maskCoordinates());
  copy(triangles, mirror.triangles());
  copy(patches, mirror.patches());
  copy(tess, mirror.tess());
  copy(pieces, mirror.pieces());
  copy(objects, mirror.objects());
}

}  // namespace tessera::view
