#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/mesh_formats_detail.hpp"

namespace batten::detail {

namespace {

enum class Type { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };

size_t size_of(Type type) {
  switch (type) {
    case Type::Int8:
    case Type::Uint8:
      return 1;
    case Type::Int16:
    case Type::Uint16:
      return 2;
    case Type::Int32:
    case Type::Uint32:
    case Type::Float32:
      return 4;
    case Type::Float64:
      return 8;
  }
  return 0;
}

bool type_of(std::string_view name, Type& type) {
  struct Name {
    std::string_view text;
    Type type;
  };
  static constexpr Name kNames[] = {
      {"char", Type::Int8},      {"int8", Type::Int8},       {"uchar", Type::Uint8},
      {"uint8", Type::Uint8},    {"short", Type::Int16},     {"int16", Type::Int16},
      {"ushort", Type::Uint16},  {"uint16", Type::Uint16},   {"int", Type::Int32},
      {"int32", Type::Int32},    {"uint", Type::Uint32},     {"uint32", Type::Uint32},
      {"float", Type::Float32},  {"float32", Type::Float32}, {"double", Type::Float64},
      {"float64", Type::Float64}};
  for (const Name& entry : kNames)
    if (entry.text == name) {
      type = entry.type;
      return true;
    }
  return false;
}

const char* type_name(Type type) {
  static constexpr const char* kWords[] = {"char", "uchar", "short", "ushort",
                                           "int",  "uint",  "float", "double"};
  return kWords[static_cast<int>(type)];
}

struct Property {
  std::string name;
  Type type = Type::Float32;
  bool list = false;
  Type count_type = Type::Uint8;
};

struct Element {
  std::string name;
  long count = 0;
  std::vector<Property> properties;
};

enum class Encoding { Ascii, Little, Big };

struct Header {
  Encoding encoding = Encoding::Ascii;
  std::vector<Element> elements;
  std::vector<std::string> texture_files;
  size_t size = 0;   // bytes
  long n_lines = 0;  // lines
};

/// The words of a line "format ENCODING 1.0". False when they are none.
bool parse_format(const std::vector<std::string_view>& words, Encoding& encoding) {
  if (words.size() < 2) return false;
  if (words[1] == "ascii")
    encoding = Encoding::Ascii;
  else if (words[1] == "binary_little_endian")
    encoding = Encoding::Little;
  else if (words[1] == "binary_big_endian")
    encoding = Encoding::Big;
  else
    return false;
  return true;
}

bool is_floating(Type type) {
  return type == Type::Float32 || type == Type::Float64;
}

/// The words of a line "property TYPE NAME" or "property list TYPE TYPE NAME". False when they are none.
bool parse_property(const std::vector<std::string_view>& words, Property& property) {
  property.list = words.size() > 1 && words[1] == "list";
  const bool known = property.list ? words.size() == 5 && type_of(words[2], property.count_type) &&
                                         type_of(words[3], property.type)
                                   : words.size() == 3 && type_of(words[1], property.type);
  if (known) property.name = words.back();
  return known;
}

Header parse_header(std::string_view content, const std::string& path) {
  Header header;
  size_t begin = content.substr(0, 3) == "\xEF\xBB\xBF" ? 3 : 0;
  bool has_format = false;
  while (true) {
    const size_t end = content.find('\n', begin);
    if (end == std::string_view::npos || end - begin > 100000)
      throw FileError(path, header.n_lines + 1,
                      "the PLY header has no 'end_header' line; the file is truncated or no PLY file");
    const std::string_view line = content.substr(begin, end - begin);
    begin = end + 1;
    ++header.n_lines;
    const auto fail = [&](std::string_view problem) { throw FileError(path, header.n_lines, problem); };
    const std::vector<std::string_view> words = split_blanks(line);
    if (header.n_lines == 1) {
      if (words.size() != 1 || words[0] != "ply") fail("expected 'ply' on the first line");
      continue;
    }
    if (words.size() >= 3 && words[0] == "comment" && words[1] == "TextureFile")
      header.texture_files.emplace_back(trim(line.substr(line.find("TextureFile") + 11)));
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format") {
      if (!parse_format(words, header.encoding))
        fail("expected 'format ascii|binary_little_endian|binary_big_endian 1.0'");
      has_format = true;
    } else if (words[0] == "element") {
      Element element;
      if (words.size() != 3 || !parse_integer(words[2], element.count) || element.count < 0)
        fail("expected 'element NAME COUNT' with a count of at least 0");
      element.name = words[1];
      header.elements.push_back(element);
    } else if (words[0] == "property") {
      if (header.elements.empty()) fail("a property stands before the first element");
      Property property;
      if (!parse_property(words, property))
        fail("expected 'property TYPE NAME' or 'property list TYPE TYPE NAME' with the types of PLY 1.0");
      if (property.list && is_floating(property.count_type))
        fail("the length of a list must be of an integer type");
      header.elements.back().properties.push_back(property);
    } else {
      fail(concat("unknown header line '", line.substr(0, 40), "'"));
    }
  }
  if (!has_format) throw FileError(path, 2, "the PLY header has no 'format' line");
  header.size = begin;
  return header;
}

/// The number that the lowest bits stand for.
double number_of(Type type, std::uint64_t bits) {
  switch (type) {
    case Type::Int8:
      return static_cast<std::int8_t>(bits);
    case Type::Uint8:
      return static_cast<std::uint8_t>(bits);
    case Type::Int16:
      return static_cast<std::int16_t>(bits);
    case Type::Uint16:
      return static_cast<std::uint16_t>(bits);
    case Type::Int32:
      return static_cast<std::int32_t>(bits);
    case Type::Uint32:
      return static_cast<std::uint32_t>(bits);
    case Type::Float32: {
      float value = 0;
      const auto half = static_cast<std::uint32_t>(bits);
      std::memcpy(&value, &half, sizeof value);
      return value;
    }
    case Type::Float64: {
      double value = 0;
      std::memcpy(&value, &bits, sizeof value);
      return value;
    }
  }
  return 0;
}

/// Values one after the other, from text or bytes. The errors name the element being read.
class Values {
 public:
  Values(std::string_view content, const Header& header, const std::string& path)
      : content_(content), encoding_(header.encoding), path_(path), at_(header.size), line_(header.n_lines) {}

  size_t bytes_left() const { return content_.size() - at_; }

  void begin_row(const Element& element, long index) {
    element_ = &element;
    index_ = index;
    if (encoding_ != Encoding::Ascii) return;
    std::string_view line;
    do {
      if (at_ >= content_.size())
        fail(concat("is missing; the file ends after ", index, " of ", element.count));
      const size_t end = std::min(content_.find('\n', at_), content_.size());
      line = content_.substr(at_, end - at_);
      at_ = std::min(end + 1, content_.size());
      ++line_;
    } while (trim(line).empty());
    tokens_ = Tokens(line);
  }

  double next(Type type, std::string_view property) {
    if (encoding_ == Encoding::Ascii) {
      std::string_view token;
      if (!tokens_.next(token)) fail(concat("has no '", property, "'; the line has too few values"));
      double value = 0;
      if (!parse_number(token, value)) fail(concat("has a '", property, "' that is no number"));
      return value;
    }
    const size_t size = size_of(type);
    if (bytes_left() < size)
      fail(concat("is not complete; the file is truncated (", element_->count, " announced)"));
    unsigned char bytes[8];
    for (size_t k = 0; k < size; ++k)
      bytes[encoding_ == Encoding::Little ? k : size - 1 - k] = static_cast<unsigned char>(content_[at_ + k]);
    at_ += size;
    std::uint64_t bits = 0;
    for (size_t k = size; k-- > 0;) bits = bits << 8 | bytes[k];
    return number_of(type, bits);
  }

  /// The length of a list, held against what is left of the file.
  long next_length(const Property& property) {
    const double length = next(property.count_type, property.name);
    if (!(length >= 0) || length != std::floor(length))
      fail(concat("has a '", property.name, "' of length ", length,
                  ", expected a whole number of at least 0"));
    const double least = encoding_ == Encoding::Ascii ? 1 : static_cast<double>(size_of(property.type));
    if (length * least > static_cast<double>(encoding_ == Encoding::Ascii ? content_.size() : bytes_left()))
      fail(concat("has a '", property.name, "' of length ", length, ", longer than the rest of the file"));
    return static_cast<long>(length);
  }

  void skip_list(const Property& property) {
    const long length = next_length(property);
    if (encoding_ == Encoding::Ascii)
      for (long k = 0; k < length; ++k) next(property.type, property.name);
    else
      at_ += static_cast<size_t>(length) * size_of(property.type);
  }

  /// More than announced is an error in text, where counting lines is what the format does; behind binary
  /// data some programs leave bytes of their own.
  void check_end(std::vector<std::string>& warnings) {
    const std::string_view rest = content_.substr(at_);
    if (trim(rest).empty()) return;
    if (encoding_ == Encoding::Ascii)
      throw FileError(path_, line_ + 1, "more lines follow than the header announces; correct its counts");
    warnings.push_back(concat(rest.size(), " bytes behind the announced elements were left out"));
  }

  [[noreturn]] void fail(std::string_view problem) const {
    throw FileError(path_, encoding_ == Encoding::Ascii ? line_ : 0,
                    concat(element_->name, " ", index_, " ", problem));
  }

 private:
  std::string_view content_;
  Encoding encoding_;
  const std::string& path_;
  size_t at_;
  long line_;
  const Element* element_ = nullptr;
  long index_ = 0;
  Tokens tokens_{""};
};

/// No count is believed before the file is seen to be long enough for it.
void check_size(const Element& element, Encoding encoding, size_t bytes_left, const std::string& path) {
  double least = 0;
  for (const Property& property : element.properties)
    least += encoding == Encoding::Ascii
                 ? 2.0
                 : static_cast<double>(size_of(property.list ? property.count_type : property.type));
  // The last value of a text file may lack its line end.
  if (least * static_cast<double>(element.count) > static_cast<double>(bytes_left) + 1)
    throw FileError(
        path, 0,
        concat("the header announces ", element.count, " elements '", element.name, "', but only ",
               bytes_left, " bytes follow; the file is truncated or its count is wrong"));
}

void read_vertices(RawMesh& mesh, const Element& element, Values& values) {
  const std::string_view kKnown[] = {"x", "y", "z", "nx", "ny", "nz"};
  int found[6] = {0, 0, 0, 0, 0, 0};
  std::vector<int> target;  // per property: 0–5 as above, 6 + k for the k-th further value, −1 for lists
  std::vector<std::string> further;
  for (const Property& property : element.properties) {
    int place = -1;
    if (!property.list) {
      for (int k = 0; k < 6; ++k)
        if (property.name == kKnown[k] && found[k]++ == 0) place = k;
      if (place < 0) {
        place = 6 + static_cast<int>(further.size());
        further.push_back(property.name);
      }
      mesh.attributes.vertex_properties.push_back({property.name, type_name(property.type)});
    }
    target.push_back(place);
  }
  const auto n = static_cast<size_t>(element.count);
  const bool has_normals = found[3] && found[4] && found[5];
  std::vector<Eigen::VectorXd> further_values(further.size(), Eigen::VectorXd(element.count));
  mesh.positions.resize(3 * n);
  if (has_normals) mesh.normals.resize(3 * n);
  for (size_t v = 0; v < n; ++v) {
    values.begin_row(element, static_cast<long>(v));
    for (size_t p = 0; p < target.size(); ++p) {
      const Property& property = element.properties[p];
      if (target[p] < 0) {
        values.skip_list(property);
        continue;
      }
      const double value = values.next(property.type, property.name);
      const auto k = static_cast<size_t>(target[p]);
      if (k < 3) {
        if (!std::isfinite(value))
          values.fail(concat("has the ", property.name, " ", value, ", which is not finite; remove it"));
        mesh.positions[3 * v + k] = value;
      } else if (k < 6) {
        if (has_normals) mesh.normals[3 * v + k - 3] = value;
      } else {
        further_values[k - 6](static_cast<Eigen::Index>(v)) = value;
      }
    }
  }
  for (size_t k = 0; k < further.size(); ++k) mesh.vertex_values[further[k]] = std::move(further_values[k]);
}

/// Texture coordinates of the corners of the face added last, or none where their number does not fit.
void add_texture(RawMesh& mesh, size_t n_corners, const std::vector<double>& texture) {
  const bool fits = texture.size() == 2 * n_corners;
  for (size_t k = 0; k < n_corners; ++k)
    mesh.corner_texture.push_back(fits ? static_cast<int>(mesh.texture.size() / 2 + k) : -1);
  if (fits) mesh.texture.insert(mesh.texture.end(), texture.begin(), texture.end());
}

void read_faces(RawMesh& mesh, const Element& element, long n_vertices, Values& values) {
  int corners_at = -1;
  for (size_t p = 0; p < element.properties.size(); ++p)
    if (element.properties[p].list &&
        (element.properties[p].name == "vertex_indices" || element.properties[p].name == "vertex_index"))
      corners_at = static_cast<int>(p);
  std::vector<MeshAttributes::Property>& scalars = mesh.attributes.face_properties;
  for (const Property& property : element.properties)
    if (!property.list) scalars.push_back({property.name, type_name(property.type)});
  mesh.face_values.resize(scalars.size());
  std::vector<double> of_face, texture;
  std::vector<int> corners;
  for (long f = 0; f < element.count; ++f) {
    values.begin_row(element, f);
    of_face.clear();
    texture.clear();
    if (corners_at < 0) values.fail("has no list 'vertex_indices'; is this a mesh?");
    for (size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      if (static_cast<int>(p) != corners_at) {
        if (!property.list)
          of_face.push_back(values.next(property.type, property.name));
        else if (property.name == "texcoord")
          for (long left = values.next_length(property); left > 0; --left)
            texture.push_back(values.next(property.type, property.name));
        else
          values.skip_list(property);
        continue;
      }
      const long length = values.next_length(property);
      corners.clear();
      for (long k = 0; k < length; ++k) {
        const double index = values.next(property.type, property.name);
        if (!(index >= 0 && index < static_cast<double>(n_vertices)) || index != std::floor(index))
          values.fail(concat("names vertex ", index, ", expected 0 to ", n_vertices - 1));
        corners.push_back(static_cast<int>(index));
      }
    }
    if (!add_face(mesh, corners)) continue;
    for (size_t p = 0; p < of_face.size(); ++p) mesh.face_values[p].push_back(of_face[p]);
    add_texture(mesh, corners.size(), texture);
  }
}

}  // namespace

RawMesh parse_ply(std::string_view content, const std::string& path) {
  const Header header = parse_header(content, path);
  RawMesh mesh;
  mesh.attributes.texture_files = header.texture_files;
  Values values(content, header, path);
  long n_vertices = -1;
  for (const Element& element : header.elements) {
    if (element.properties.empty()) continue;  // nothing is stored for it
    check_size(element, header.encoding, values.bytes_left(), path);
    if (element.name == "vertex") {
      if (n_vertices >= 0) throw FileError(path, 0, "the header announces two elements 'vertex'; keep one");
      for (const char* axis : {"x", "y", "z"})
        if (std::none_of(element.properties.begin(), element.properties.end(),
                         [&](const Property& p) { return p.name == axis && !p.list; }))
          throw FileError(path, 0, concat("the vertices have no property '", axis, "'; is this a mesh?"));
      if (element.count > std::numeric_limits<int>::max() / 3)
        throw FileError(path, 0, concat(element.count, " vertices are more than this program can hold"));
      n_vertices = element.count;
      read_vertices(mesh, element, values);
    } else if (element.name == "face") {
      if (n_vertices < 0)
        throw FileError(path, 0, "the faces stand before the vertices; write the vertices first");
      read_faces(mesh, element, n_vertices, values);
    } else {
      if (element.name == "tristrips")
        throw FileError(path, 0, "holds triangle strips, which are not read; export plain faces");
      for (long row = 0; row < element.count; ++row) {
        values.begin_row(element, row);
        for (const Property& property : element.properties) {
          if (property.list)
            values.skip_list(property);
          else
            values.next(property.type, property.name);
        }
      }
      if (element.count > 0)
        mesh.warnings.push_back(concat(element.count, " elements '", element.name, "' were left out"));
    }
  }
  if (n_vertices < 0) throw FileError(path, 0, "the header announces no element 'vertex'");
  values.check_end(mesh.warnings);
  return mesh;
}

}  // namespace batten::detail
