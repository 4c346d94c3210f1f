#include "batten/io/handles_io.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string_view>

#include <nlohmann/json.hpp>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;
using Json = nlohmann::json;

class HandleReader {
 public:
  HandleReader(const std::string& path, const Points& positions)
      : path_(path), positions_(positions), user_(positions.rows()) {}

  Handles read(const std::string& text) {
    const Json json = Json::parse(text, nullptr, false);
    if (json.is_discarded()) fail("is not JSON; see docs/deform.md for the form of handles");
    check_object(json, "the file", {"fixed", "handles"});
    Handles handles;
    if (json.contains("fixed")) handles.fixed = selection(json["fixed"], "fixed");
    if (!json.contains("handles") || !json["handles"].is_array()) fail("'handles' must be a list");
    for (std::size_t i = 0; i < json["handles"].size(); ++i)
      handles.moved.push_back(motion(json["handles"][i], concat("handles[", i, "]")));
    return handles;
  }

 private:
  [[noreturn]] void fail(std::string_view problem) const { throw FileError(path_, 0, problem); }

  void check_object(const Json& json, const std::string& place,
                    std::initializer_list<std::string_view> known) const {
    if (!json.is_object()) fail(concat(place, " must be an object in braces"));
    for (const auto& [key, value] : json.items())
      if (std::find(known.begin(), known.end(), key) == known.end())
        fail(concat(place, " has the unknown member '", key, "'"));
  }

  std::vector<double> numbers(const Json& json, const std::string& place, std::size_t count) const {
    if (!json.is_array() || json.size() != count)
      fail(concat(place, " must be a list of ", count, " numbers"));
    std::vector<double> values;
    for (const Json& value : json) {
      if (!value.is_number() || !std::isfinite(value.get<double>()))
        fail(concat(place, " must hold finite numbers only"));
      values.push_back(value.get<double>());
    }
    return values;
  }
  Vector3d vector(const Json& json, const std::string& place) const {
    const std::vector<double> values = numbers(json, place, 3);
    return {values[0], values[1], values[2]};
  }

  std::vector<int> selection(const Json& json, const std::string& place) {
    check_object(json, place, {"vertices", "box", "sphere"});
    if (json.size() != 1) fail(concat(place, " must have exactly one of 'vertices', 'box' and 'sphere'"));
    std::vector<int> vertices;
    if (json.contains("vertices")) {
      const Json& list = json["vertices"];
      if (!list.is_array()) fail(concat(place, ".vertices must be a list"));
      for (const Json& value : list) {
        const double v = value.is_number_integer() ? value.get<double>() : -1;
        if (v < 0 || v >= static_cast<double>(positions_.rows()))
          fail(concat(place, ".vertices must hold vertex numbers from 0 to ", positions_.rows() - 1, ", not ",
                      value.dump()));
        vertices.push_back(static_cast<int>(v));
      }
    } else if (json.contains("box")) {
      const Json& box = json["box"];
      if (!box.is_array() || box.size() != 2) fail(concat(place, ".box must be a list of two corners"));
      const Vector3d a = vector(box[0], concat(place, ".box[0]")),
                     b = vector(box[1], concat(place, ".box[1]"));
      const Vector3d low = a.cwiseMin(b), high = a.cwiseMax(b);
      for (Eigen::Index v = 0; v < positions_.rows(); ++v) {
        const Vector3d p = positions_.row(v);
        if ((p.array() >= low.array()).all() && (p.array() <= high.array()).all())
          vertices.push_back(static_cast<int>(v));
      }
    } else {
      const std::vector<double> sphere = numbers(json["sphere"], concat(place, ".sphere"), 4);
      if (!(sphere[3] > 0)) fail(concat(place, ".sphere must have a radius above 0"));
      for (Eigen::Index v = 0; v < positions_.rows(); ++v)
        if ((Vector3d(positions_.row(v)) - Vector3d(sphere[0], sphere[1], sphere[2])).norm() <= sphere[3])
          vertices.push_back(static_cast<int>(v));
    }
    if (vertices.empty()) fail(concat(place, " selects no vertex; make it larger"));
    for (const int v : vertices) {
      if (!user_[v].empty()) fail(concat("vertex ", v, " is selected by ", user_[v], " and by ", place));
      user_[v] = place;
    }
    return vertices;
  }

  HandleMotion motion(const Json& json, const std::string& place) {
    check_object(json, place, {"select", "translate", "rotate_deg", "about", "targets"});
    if (!json.contains("select")) fail(concat(place, " has no 'select'"));
    HandleMotion motion;
    motion.vertices = selection(json["select"], concat(place, ".select"));
    if (json.contains("targets")) {
      if (json.size() != 2) fail(concat(place, " has targets and a motion; give one of them"));
      const Json& targets = json["targets"];
      if (!targets.is_array() || targets.size() != motion.vertices.size())
        fail(concat(place, ".targets must be a list of ", motion.vertices.size(), " points, one per vertex"));
      motion.targets.resize(static_cast<Eigen::Index>(targets.size()), 3);
      for (std::size_t i = 0; i < targets.size(); ++i)
        motion.targets.row(static_cast<Eigen::Index>(i)) =
            vector(targets[i], concat(place, ".targets[", i, "]"));
      return motion;
    }
    if (json.contains("translate"))
      motion.translation = vector(json["translate"], concat(place, ".translate"));
    if (json.contains("about")) motion.about = vector(json["about"], concat(place, ".about"));
    if (json.contains("rotate_deg")) {
      const std::vector<double> values = numbers(json["rotate_deg"], concat(place, ".rotate_deg"), 4);
      motion.axis = Vector3d(values[0], values[1], values[2]);
      if (!(motion.axis.norm() > 0)) fail(concat(place, ".rotate_deg has no axis: its first three are 0"));
      motion.axis.normalize();
      motion.angle = radians(values[3]);
    }
    return motion;
  }

  std::string path_;
  const Points& positions_;
  std::vector<std::string> user_;  ///< per vertex: the selection that has it
};

}  // namespace

Handles read_handles(const std::string& path, const Points& positions) {
  return parse_handles(read_file(path), path, positions);
}

Handles parse_handles(const std::string& text, const std::string& name, const Points& positions) {
  return HandleReader(name, positions).read(text);
}

}  // namespace batten
