#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/mesh_formats_detail.hpp"
#include "batten/io/zip_archive.hpp"

// 3MF Core Specification 1.3, and of the production extension the paths to further models.
namespace batten::detail {

namespace {

/// Components deeper than this are a loop or nothing that anybody made.
constexpr int kDeepestComponent = 100;
constexpr long kMostOfModel = std::numeric_limits<int>::max() / 3;

/// A name without the prefix of its namespace.
std::string_view local_name(std::string_view name) {
  const size_t colon = name.rfind(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

struct XmlTag {
  std::string_view name;
  bool is_end = false, is_empty = false;  // </name>, <name/>
  std::vector<std::pair<std::string_view, std::string_view>> attributes;

  std::string_view attribute(std::string_view wanted) const {
    for (const auto& [key, value] : attributes)
      if (key == wanted) return value;
    return {};
  }
};

/// The tags of an XML file one after the other; text between them, comments and declarations are passed over.
class XmlTags {
 public:
  XmlTags(std::string_view text, const std::string& path) : text_(text), path_(path) {}

  bool next(XmlTag& tag) {
    for (;;) {
      const size_t begin = text_.find('<', at_);
      if (begin == std::string_view::npos) return false;
      if (text_.substr(begin, 4) == "<!--") {
        at_ = behind("-->", begin);
      } else if (text_.substr(begin, 2) == "<?" || text_.substr(begin, 2) == "<!") {
        at_ = behind(">", begin);
      } else {
        read(begin + 1, tag);
        return true;
      }
    }
  }

 private:
  size_t behind(std::string_view mark, size_t from) const {
    const size_t found = text_.find(mark, from);
    if (found == std::string_view::npos) throw FileError(path_, 0, "the XML of the model is cut off");
    return found + mark.size();
  }
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

  void read(size_t at, XmlTag& tag) {
    const auto word_end = [&](size_t from) {
      while (from < text_.size() && !is_blank(text_[from]) && text_[from] != '=' && text_[from] != '>' &&
             text_[from] != '/')
        ++from;
      return from;
    };
    tag.attributes.clear();
    tag.is_end = at < text_.size() && text_[at] == '/';
    tag.is_empty = false;
    if (tag.is_end) ++at;
    size_t end = word_end(at);
    tag.name = local_name(text_.substr(at, end - at));
    for (at = end; at < text_.size() && text_[at] != '>';) {
      if (is_blank(text_[at]) || text_[at] == '/') {
        tag.is_empty = text_[at] == '/' || tag.is_empty;
        ++at;
        continue;
      }
      end = word_end(at);
      const size_t quote = text_.find_first_of("\"'", end);
      if (quote == std::string_view::npos || end == at)
        throw FileError(path_, 0, "the XML of the model is damaged");
      const size_t close = behind(text_.substr(quote, 1), quote + 1);
      tag.attributes.emplace_back(local_name(text_.substr(at, end - at)),
                                  text_.substr(quote + 1, close - quote - 2));
      at = close;
    }
    at_ = behind(">", at);
  }

  std::string_view text_;
  const std::string& path_;
  size_t at_ = 0;
};

/// A use of an object: which, of which model of the archive, and where.
struct Use {
  std::string model, id;
  Eigen::Matrix<double, 4, 3> transform;  // rows act on (x, y, z, 1) from the left
};

struct Object {
  std::vector<double> positions;  // 3 each
  std::vector<int> triangles;     // 3 each
  std::vector<Use> components;
};

class ThreeMfParser {
 public:
  explicit ThreeMfParser(const std::string& path) : path_(path) {}

  RawMesh parse(std::string_view content) {
    std::map<std::string, std::string> entries;
    try {
      entries = parse_archive(std::string(content));
    } catch (const InvalidInput& problem) {
      throw FileError(path_, 0, concat("no 3MF file: ", problem.what()));
    }
    const std::string root = root_model(entries);
    for (const auto& [name, text] : entries)
      if (name.size() > 6 && name.compare(name.size() - 6, 6, ".model") == 0)
        read_model(name, text, name == root);
    if (items_.empty()) throw FileError(path_, 0, "the build of the model has no items, so there is no mesh");
    for (const Use& item : items_) add(item, identity(), 0);
    if (metres_ != 0.001)
      mesh_.warnings.push_back(concat("a length of 1 of the file is ", metres_, " m; lengths are in m here"));
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(std::string_view problem) const { throw FileError(path_, 0, problem); }

  static Eigen::Matrix<double, 4, 3> identity() {
    Eigen::Matrix<double, 4, 3> transform = Eigen::Matrix<double, 4, 3>::Zero();
    transform.topRows<3>().setIdentity();
    return transform;
  }

  std::string root_model(const std::map<std::string, std::string>& entries) const {
    if (const auto found = entries.find("_rels/.rels"); found != entries.end()) {
      XmlTags tags(found->second, path_);
      for (XmlTag tag; tags.next(tag);) {
        const std::string_view type = tag.attribute("Type");
        if (tag.name != "Relationship" || type.substr(type.rfind('/') + 1) != "3dmodel") continue;
        const std::string target = entry_name(tag.attribute("Target"));
        if (entries.count(target) > 0) return target;
      }
    }
    if (entries.count("3D/3dmodel.model") == 0) fail("holds no model '3D/3dmodel.model'; is it a 3MF file?");
    return "3D/3dmodel.model";
  }

  static std::string entry_name(std::string_view path) {
    return std::string(path.substr(!path.empty() && path[0] == '/' ? 1 : 0));
  }

  double number(const XmlTag& tag, std::string_view name) const {
    double value = 0;
    if (!parse_number(tag.attribute(name), value) || !std::isfinite(value))
      fail(concat("a ", tag.name, " has no number '", name, "'"));
    return value;
  }

  int index(const XmlTag& tag, std::string_view name, size_t count) const {
    long value = 0;
    if (!parse_integer(tag.attribute(name), value) || value < 0 || value >= static_cast<long>(count))
      fail(concat("a triangle names vertex '", tag.attribute(name), "', expected 0 to ",
                  static_cast<long>(count) - 1));
    return static_cast<int>(value);
  }

  Use use(const XmlTag& tag, const std::string& model) const {
    const std::string_view other = tag.attribute("path");
    Use result{other.empty() ? model : entry_name(other), std::string(tag.attribute("objectid")), identity()};
    const std::vector<std::string_view> words = split_blanks(tag.attribute("transform"));
    if (words.empty()) return result;
    if (words.size() != 12) fail("a transform has other than 12 numbers");
    for (int k = 0; k < 12; ++k)
      if (!parse_number(words[static_cast<size_t>(k)], result.transform(k / 3, k % 3)) ||
          !std::isfinite(result.transform(k / 3, k % 3)))
        fail("a transform has an entry that is no number");
    return result;
  }

  void read_model(const std::string& name, const std::string& text, bool is_root) {
    XmlTags tags(text, path_);
    Object* object = nullptr;
    for (XmlTag tag; tags.next(tag);) {
      if (tag.is_end) {
        if (tag.name == "object") object = nullptr;
      } else if (tag.name == "model" && is_root) {
        set_unit(tag.attribute("unit"));
      } else if (tag.name == "object") {
        object = &objects_[{name, std::string(tag.attribute("id"))}];
      } else if (tag.name == "item" && is_root) {
        items_.push_back(use(tag, name));
      } else if (object != nullptr) {
        read_part(tag, name, *object);
      }
    }
  }

  void read_part(const XmlTag& tag, const std::string& name, Object& object) const {
    if (tag.name == "vertex") {
      for (const char* axis : {"x", "y", "z"}) object.positions.push_back(number(tag, axis));
    } else if (tag.name == "triangle") {
      for (const char* corner : {"v1", "v2", "v3"})
        object.triangles.push_back(index(tag, corner, object.positions.size() / 3));
    } else if (tag.name == "component") {
      object.components.push_back(use(tag, name));
    }
  }

  void set_unit(std::string_view unit) {
    static constexpr std::pair<std::string_view, double> kUnits[] = {
        {"micron", 1e-6}, {"millimeter", 1e-3}, {"centimeter", 1e-2},
        {"inch", 0.0254}, {"foot", 0.3048},     {"meter", 1}};
    if (unit.empty()) return;
    for (const auto& [name, metres] : kUnits)
      if (name == unit) {
        metres_ = metres;
        return;
      }
    fail(concat("the unit '", unit.substr(0, 30), "' is none of 3MF"));
  }

  void add(const Use& use, const Eigen::Matrix<double, 4, 3>& outer, int depth) {
    if (depth > kDeepestComponent) fail("components contain each other");
    const auto found = objects_.find({use.model, use.id});
    if (found == objects_.end()) fail(concat("the object '", use.id, "' is used but not there"));
    const Object& object = found->second;
    Eigen::Matrix<double, 4, 3> transform = use.transform * outer.topRows<3>();
    transform.row(3) += outer.row(3);
    for (const Use& component : object.components) {
      if (++n_used_ > kMostOfModel / 100) fail("components are too many for this program");
      add(component, transform, depth + 1);
    }
    const auto first = static_cast<int>(mesh_.positions.size() / 3);
    const auto n = static_cast<long>(object.positions.size() / 3 + object.triangles.size() / 3);
    if (first + n + static_cast<long>(mesh_.faces.corners.size() / 3) > kMostOfModel)
      fail("vertices and triangles are more than this program can hold");
    for (size_t v = 0; v < object.positions.size(); v += 3) {
      const Eigen::Vector4d x(object.positions[v], object.positions[v + 1], object.positions[v + 2], 1);
      for (int k = 0; k < 3; ++k) {
        // A division keeps millimetres that were multiplied by 1000 exact.
        const double value = x.dot(transform.col(k));
        mesh_.positions.push_back(metres_ == 0.001 ? value / 1000 : metres_ * value);
      }
    }
    // A mirror image is inside out.
    const bool is_mirrored = transform.topRows<3>().determinant() < 0;
    std::vector<int> corners(3);
    for (size_t t = 0; t < object.triangles.size(); t += 3) {
      for (size_t k = 0; k < 3; ++k) corners[is_mirrored ? 2 - k : k] = first + object.triangles[t + k];
      add_face(mesh_, corners);
    }
  }

  const std::string& path_;
  RawMesh mesh_;
  std::map<std::pair<std::string, std::string>, Object> objects_;  // by model and id
  std::vector<Use> items_;
  double metres_ = 0.001;
  long n_used_ = 0;
};

}  // namespace

bool begins_as_zip(std::string_view content) {
  return content.substr(0, 4) == "PK\x03\x04";
}

RawMesh parse_threemf(std::string_view content, const std::string& path) {
  return ThreeMfParser(path).parse(content);
}

}  // namespace batten::detail
