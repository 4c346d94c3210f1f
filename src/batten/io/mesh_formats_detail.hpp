#pragma once
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/file.hpp"
#include "batten/io/mesh_attributes.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/triangle_mesh.hpp"

// What the readers of the mesh formats share. Private to the room.
namespace batten::detail {

/// A mesh as it stands in a file, before polygons are split and normals are checked.
struct RawMesh {
  std::vector<double> positions;  // 3 per vertex
  std::vector<double> normals;    // 3 per vertex, or empty
  PolygonMesh faces;              // its positions stay empty
  std::map<std::string, Eigen::VectorXd> vertex_values;
  // Of polygons: numbers per property and face, texture coordinates (2 each) and, per corner, which; the rest
  // of the attributes as they will be, with labels per polygon.
  std::vector<std::vector<double>> face_values;
  std::vector<double> texture;
  std::vector<int> corner_texture;
  MeshAttributes attributes;
  std::vector<std::string> warnings;
  long n_short_faces = 0;  // with one or two corners, left out
  // OBJ alone: `l` and `t` statements, for those who read cages.
  struct Polyline {
    std::vector<int> vertices;
    long line = 0;
  };
  struct Tag {
    std::string text;  // without the `t`
    long line = 0;
  };
  std::vector<Polyline> polylines;
  std::vector<Tag> tags;
};

/// One corner list; shorter ones than three are counted and left out: false.
bool add_face(RawMesh& mesh, const std::vector<int>& corners);

RawMesh parse_ply(std::string_view content, const std::string& path);
RawMesh parse_obj_mesh(std::string content, const std::string& path);
RawMesh parse_off(std::string content, const std::string& path);
RawMesh parse_stl(std::string content, const std::string& path);
/// Of a GLB, or a glTF with its buffers beside it: all meshes of the scene in their places, as one.
RawMesh parse_gltf(std::string_view content, const std::string& path);

/// All objects of the build of a 3MF in their places, as one, in metres.
RawMesh parse_threemf(std::string_view content, const std::string& path);
/// Whether the bytes are a zip file, which of the formats here only 3MF is.
bool begins_as_zip(std::string_view content);

std::string ply_text(const TriangleMesh& mesh, const MeshAttributes& attributes, bool ascii);
std::string obj_text(const TriangleMesh& mesh, const MeshAttributes& attributes);
/// Whether obj_text() writes colours.
bool has_byte_colours(const TriangleMesh& mesh);
std::string glb_bytes(const TriangleMesh& mesh, double metres_per_unit);
std::string threemf_bytes(const TriangleMesh& mesh, double metres_per_unit);

/// The format that a content shows beyond doubt; nothing when it could be several.
std::optional<MeshFormat> shown_mesh_format(std::string_view content);

/// The mesh of a file of any format, found by content and extension; `notes` gets what differs between both.
RawMesh parse_raw_mesh(std::string content, const std::string& path, std::vector<std::string>& notes);

/// Polygons split, normals of unit length, everything reported in warnings; what no TriangleMesh holds to
/// `attributes`, or left out.
TriangleMesh finished_mesh(RawMesh&& raw, const std::string& path, std::vector<std::string>* warnings,
                           MeshAttributes* attributes = nullptr);

/// @throws InvalidInput where an index is out of range or an array of another length than it should be.
void check_arrays(const TriangleMesh& mesh);
/// The extension looks through .gz for the readers; what is written under such a name would be no gzip file.
void refuse_compressed(const std::string& path);
/// The three numbers of a row, exactly.
void append_row(std::string& text, const Points& rows, Eigen::Index row);

/// True when the bytes can only be a binary STL: 80 bytes, a count, and exactly 50 bytes for each.
bool is_binary_stl(std::string_view content);
/// Some programs write something of their own behind the last facet of a binary STL. Whole facets there mean
/// that the number announced is wrong.
bool has_bytes_behind_facets(std::string_view content);
/// Whether the bytes are a GLB, or JSON that looks like glTF.
bool begins_as_gltf(std::string_view content);
/// Whether a text begins as STL does: `solid`, in any letters.
bool begins_as_text_stl(std::string_view content);

/// Tokens of a line one after the other, without copying.
class Tokens {
 public:
  explicit Tokens(std::string_view line) : rest_(line) {}
  /// False at the end of the line.
  bool next(std::string_view& token);

 private:
  std::string_view rest_;
};

/// Reads a finite number out of `tokens`. @param what names it in the error ("x of vertex 7").
double read_finite(Tokens& tokens, const LineReader& reader, std::string_view what);
/// Reads an integer within [low, high].
long read_integer(Tokens& tokens, const LineReader& reader, std::string_view what, long low, long high);

/// The text up to a `#`.
std::string_view without_comment(std::string_view line);

}  // namespace batten::detail
