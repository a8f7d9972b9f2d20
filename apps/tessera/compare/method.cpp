#include "apps/tessera/compare/method.hpp"

#include <charconv>
#include <cmath>
#include <map>

namespace tessera::app {

Result<Method> parseMethod(const std::string& text, double defaultBias) {
  static const std::map<std::string, Kind> kKinds = {{"forward", Kind::Forward},
                                                     {"forward-prepass", Kind::ForwardPrepass},
                                                     {"rect", Kind::Rect},
                                                     {"rect-deferred", Kind::RectDeferred}};
  const std::size_t colon = text.find(':');
  const auto kind = kKinds.find(text.substr(0, colon));
  if (kind == kKinds.end())
    return fail(
        "--methods {}: not one of forward, forward-prepass, rect, rect-deferred (with :bias=N for rect)",
        text);
  Method method{text, kind->second, defaultBias};
  if (colon == std::string::npos) return method;
  constexpr std::string_view kBias = "bias=";
  const std::string_view option = std::string_view(text).substr(colon + 1);
  const char* end = text.data() + text.size();
  if (!method.usesAtlas() || option.substr(0, kBias.size()) != kBias ||
      std::from_chars(option.data() + kBias.size(), end, method.bias).ptr != end ||
      !(std::abs(method.bias) <= 16.0))
    return fail("--methods {}: after the colon only bias=N, -16 to 16, for rect methods", text);
  return method;
}

}  // namespace tessera::app
