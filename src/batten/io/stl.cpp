#include <cmath>
#include <cstdint>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/exact_merger_detail.hpp"
#include "batten/io/little_endian_detail.hpp"
#include "batten/io/mesh_formats_detail.hpp"

namespace batten::detail {

namespace {

constexpr size_t kHeader = 84, kFacet = 50;

RawMesh parse_binary(std::string_view content, const std::string& path) {
  RawMesh mesh;
  ExactMerger merger(mesh);
  const size_t n = little_endian<std::uint32_t>(content.data() + 80);
  for (size_t f = 0; f < n; ++f) {
    const char* facet = content.data() + kHeader + f * kFacet;
    std::vector<int> corners;
    for (size_t k = 0; k < 3; ++k) {
      double coordinates[3];
      for (size_t axis = 0; axis < 3; ++axis) {
        const float value = little_endian<float>(facet + 12 + 12 * k + 4 * axis);
        if (!std::isfinite(value))
          throw FileError(
              path, 0,
              concat("facet ", f, " has the coordinate ", value, ", which is not finite; remove it"));
        coordinates[axis] = value;
      }
      corners.push_back(merger.vertex(coordinates[0], coordinates[1], coordinates[2]));
    }
    add_face(mesh, corners);
  }
  return mesh;
}

RawMesh parse_text(std::string content, const std::string& path) {
  RawMesh mesh;
  ExactMerger merger(mesh);
  LineReader reader(std::move(content), path);
  std::string_view line, word;
  std::vector<int> corners;
  bool in_solid = false, in_loop = false;
  long solid_line = 0;
  while (reader.next(line)) {
    Tokens tokens(line);
    if (!tokens.next(word)) continue;
    const std::string keyword = lower_case(word);  // some programs write capitals
    if (keyword == "vertex") {
      if (!in_loop) reader.fail("a vertex stands outside of 'outer loop' … 'endloop'");
      double xyz[3];
      for (double& value : xyz) value = read_finite(tokens, reader, "a coordinate");
      corners.push_back(merger.vertex(xyz[0], xyz[1], xyz[2]));
    } else if (keyword == "outer") {
      in_loop = true;
      corners.clear();
    } else if (keyword == "endloop") {
      if (!in_loop || corners.size() != 3)
        reader.fail(concat("the facet has ", corners.size(), " vertices, expected 3"));
      in_loop = false;
      add_face(mesh, corners);
    } else if (keyword == "solid") {
      in_solid = true;
      solid_line = reader.line_number();
    } else if (keyword == "endsolid") {
      in_solid = false;
    } else if (keyword != "facet" && keyword != "endfacet") {
      reader.fail("expected solid, facet, outer loop, vertex, endloop, endfacet or endsolid");
    }
  }
  if (in_loop || in_solid)
    reader.fail(concat("the solid begun on line ", solid_line, " has no 'endsolid'; the file is truncated"));
  return mesh;
}

}  // namespace

bool is_binary_stl(std::string_view content) {
  return content.size() >= kHeader && (content.size() - kHeader) % kFacet == 0 &&
         (content.size() - kHeader) / kFacet == little_endian<std::uint32_t>(content.data() + 80);
}

bool has_bytes_behind_facets(std::string_view content) {
  if (content.size() < kHeader) return false;
  const std::size_t announced = little_endian<std::uint32_t>(content.data() + 80),
                    behind = content.size() - kHeader;
  return announced > 0 && behind / kFacet >= announced && (behind - announced * kFacet) % kFacet != 0;
}

bool begins_as_text_stl(std::string_view content) {
  std::string_view word;
  return Tokens(content.substr(0, 200)).next(word) && lower_case(word) == "solid";
}

RawMesh parse_stl(std::string content, const std::string& path) {
  if (is_binary_stl(content)) return parse_binary(content, path);
  if (begins_as_text_stl(content) && content.find('\0') == std::string::npos)
    return parse_text(std::move(content), path);
  if (has_bytes_behind_facets(content)) return parse_binary(content, path);
  if (content.size() >= kHeader)
    throw FileError(path, 0,
                    concat("announces ", little_endian<std::uint32_t>(content.data() + 80), " facets, but ",
                           content.size(), " bytes hold ", (content.size() - kHeader) / kFacet,
                           "; the file is truncated or no STL file"));
  throw FileError(path, 0, "is too short for an STL file");
}

}  // namespace batten::detail
