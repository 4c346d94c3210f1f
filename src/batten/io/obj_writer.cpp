#include <cmath>

#include "batten/core/text.hpp"
#include "batten/io/mesh_formats_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;

/// The three channels of colours of whole numbers from 0 to 255, or nothing.
std::vector<const Eigen::VectorXd*> colours_of(const TriangleMesh& mesh) {
  std::vector<const Eigen::VectorXd*> channels;
  for (const char* name : {"red", "green", "blue"}) {
    const auto found = mesh.vertex_values.find(name);
    if (found == mesh.vertex_values.end()) return {};
    for (const double value : found->second)
      if (!(value >= 0 && value <= 255 && std::floor(value) == value)) return {};
    channels.push_back(&found->second);
  }
  return channels;
}

/// What is said before a face where it differs from what was said before the last one.
class LabelLines {
 public:
  LabelLines(const MeshAttributes::Labels& labels, const char* keyword, const char* none)
      : labels_(labels), keyword_(keyword), none_(none) {}
  void append(std::string& text, Index face) {
    if (labels_.of_face.empty()) return;
    const int word = labels_.of_face[static_cast<std::size_t>(face)];
    if (word == last_) return;
    text += concat(keyword_, " ", word < 0 ? none_ : labels_.words[static_cast<std::size_t>(word)], "\n");
    last_ = word;
  }

 private:
  const MeshAttributes::Labels& labels_;
  const char *keyword_, *none_;
  int last_ = -1;
};

}  // namespace

bool has_byte_colours(const TriangleMesh& mesh) {
  return !colours_of(mesh).empty();
}

std::string obj_text(const TriangleMesh& mesh, const MeshAttributes& attributes) {
  std::string text = "# Batten\n";
  for (const std::string& library : attributes.libraries) text += concat("mtllib ", library, "\n");
  const std::vector<const Eigen::VectorXd*> colours = colours_of(mesh);
  for (Index v = 0; v < mesh.n_vertices(); ++v) {
    append_row(text += "v ", mesh.positions, v);
    for (const Eigen::VectorXd* channel : colours) (text += ' ') += exact_decimal((*channel)(v) / 255);
    text += '\n';
  }
  const Triangles& corners = attributes.texture_corners;
  if (corners.rows() > 0)
    for (Index t = 0; t < attributes.texture.rows(); ++t)
      text += concat("vt ", exact_decimal(attributes.texture(t, 0)), " ",
                     exact_decimal(attributes.texture(t, 1)), "\n");
  for (Index v = 0; v < mesh.normals.rows(); ++v) {
    append_row(text += "vn ", mesh.normals, v);
    text += '\n';
  }
  LabelLines objects(attributes.objects, "o", ""), groups(attributes.groups, "g", "default"),
      materials(attributes.materials, "usemtl", "");
  for (Index f = 0; f < mesh.n_triangles(); ++f) {
    objects.append(text, f);
    groups.append(text, f);
    materials.append(text, f);
    const bool textured = corners.rows() > 0 && corners.row(f).minCoeff() >= 0;
    text += 'f';
    for (int k = 0; k < 3; ++k) {
      const std::string corner = std::to_string(mesh.triangles(f, k) + 1);
      (text += ' ') += corner;
      if (textured || mesh.normals.rows() > 0) text += '/';
      if (textured) text += std::to_string(corners(f, k) + 1);
      if (mesh.normals.rows() > 0) (text += '/') += corner;
    }
    text += '\n';
  }
  return text;
}

}  // namespace batten::detail
