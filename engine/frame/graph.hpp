// The frame as a graph: a pass declares what it reads and writes; what no output needs is dropped, and memory
// barriers follow from the declarations. No GL calls here: barriers are returned as bits.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace tessera {

enum class Access : std::uint8_t {
  Storage,   // shader storage buffer, read or written in a shader
  Image,     // image load or store
  Texture,   // sampled
  Target,    // framebuffer attachment
  Indirect,  // draw or dispatch arguments
  Vertex,    // vertex attributes or indices
};

struct Use {
  std::string resource;
  Access access = Access::Storage;
};

struct Pass {
  std::string name;
  std::string stage;  // the call that runs it: "visibility", "place", "shade", "display", "forward"
  std::vector<Use> reads;
  std::vector<Use> writes;
};

class FrameGraph {
 public:
  void add(Pass pass) { passes_.push_back(std::move(pass)); }
  /// Drops every pass that none of `outputs` depends on, walking back from them.
  void keep(std::span<const std::string> outputs);
  [[nodiscard]] const std::vector<Pass>& passes() const { return passes_; }
  [[nodiscard]] const Pass* find(const std::string& name) const;
  /// Graphviz text: passes as boxes grouped by stage, resources as edges.
  [[nodiscard]] std::string graphviz() const;

 private:
  std::vector<Pass> passes_;
};

/// Remembers how each resource was last written, over stages and frames, and says which glMemoryBarrier bits
/// a pass needs before it runs. Writes of the fixed-function kind (targets) are coherent by themselves.
class BarrierTracker {
 public:
  std::uint32_t before(const Pass& pass);

 private:
  std::map<std::string, std::uint32_t>
      pending_;  // bits already issued since an incoherent write, by resource
};

/// What a frame is asked for.
struct FrameRequest {
  bool rect = false;             // shade into the rectangular atlas
  bool displayGeometry = true;   // display by geometry; with rect only
  bool displayDeferred = false;  // display from the id buffer; with rect only
  bool forward = false;
  bool depthPrepass = false;  // with forward
  bool upsample = false;      // draw forward's picture at a larger size; with forward only
  bool warp = false;          // draw forward's picture as another view sees it; with forward only
  bool lens = false;          // draw the picture of rect or forward through a lens
  /// With rect: BLEND geometry is in the visible set and the atlas too, its own colour without its alpha, and
  /// hides nothing there: for viewers that blend it themselves. The engine's own pictures are the same.
  bool blended = false;
};

struct SceneFeatures;
/// The passes of a frame for a scene, in order, with nothing that the scene and the request do not call for.
FrameGraph planFrame(const SceneFeatures& features, const FrameRequest& request);

}  // namespace tessera
