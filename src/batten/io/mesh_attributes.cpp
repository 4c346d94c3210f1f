#include "batten/io/mesh_attributes.hpp"

#include <filesystem>
#include <utility>

#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_formats_detail.hpp"
#include "batten/mesh/distance.hpp"

namespace batten {

namespace {

namespace fs = std::filesystem;

bool has_labels(const MeshAttributes::Labels& labels) {
  return !labels.of_face.empty();
}

/// Names relative to one folder, seen from another.
void move_names(std::vector<std::string>& names, const std::string& from, const std::string& to) {
  std::error_code problem;
  const fs::path there = fs::absolute(from.empty() ? "." : from, problem),
                 here = fs::absolute(to.empty() ? "." : to, problem);
  if (problem || there.lexically_normal() == here.lexically_normal()) return;
  for (std::string& name : names) {
    const fs::path path(name);
    if (path.is_relative())
      name = (there / path).lexically_normal().lexically_proximate(here.lexically_normal()).generic_string();
  }
}

/// The texture coordinates at the corners of a triangle that has the same corners as one of the input, in any
/// order; false where it has others.
bool same_corners(const MeshFile& from, Eigen::Index source, const TriangleMesh& to, Eigen::Index f,
                  Triangles& corners) {
  for (int k = 0; k < 3; ++k) {
    int found = -1;
    for (int j = 0; j < 3; ++j)
      if (to.positions.row(to.triangles(f, k)) == from.mesh.positions.row(from.mesh.triangles(source, j)))
        found = j;
    if (found < 0) return false;
    corners(f, k) = from.attributes.texture_corners(source, found);
  }
  return true;
}

}  // namespace

MeshFile parse_mesh_file(std::string content, const std::string& path, std::vector<std::string>* warnings) {
  std::vector<std::string> notes;
  detail::RawMesh raw = detail::parse_raw_mesh(std::move(content), path, notes);
  raw.warnings.insert(raw.warnings.begin(), notes.begin(), notes.end());
  MeshFile file;
  file.mesh = detail::finished_mesh(std::move(raw), path, warnings, &file.attributes);
  file.attributes.folder = fs::path(path).parent_path().string();
  return file;
}

MeshFile read_mesh_file(const std::string& path, std::vector<std::string>* warnings) {
  return parse_mesh_file(read_file(path), path, warnings);
}

std::string format_mesh_file(const MeshFile& file, MeshFormat format, const MeshWriteOptions& options) {
  if (format != MeshFormat::Ply && format != MeshFormat::Obj) return format_mesh(file.mesh, format, options);
  detail::check_arrays(file.mesh);
  return format == MeshFormat::Ply ? detail::ply_text(file.mesh, file.attributes, options.ascii)
                                   : detail::obj_text(file.mesh, file.attributes);
}

void write_mesh_file(const std::string& path, const MeshFile& file, const MeshWriteOptions& options) {
  detail::refuse_compressed(path);
  const MeshFormat format = mesh_format(path);
  if (format != MeshFormat::Ply && format != MeshFormat::Obj) {
    write_mesh(path, file.mesh, options);
    return;
  }
  MeshFile moved = file;
  const std::string folder = fs::path(path).parent_path().string();
  move_names(moved.attributes.libraries, file.attributes.folder, folder);
  move_names(moved.attributes.texture_files, file.attributes.folder, folder);
  write_file(path, format_mesh_file(moved, format, options));
}

std::vector<std::string> losses_in_format(const MeshAttributes& attributes, MeshFormat format) {
  std::vector<std::string> losses;
  if (format != MeshFormat::Ply && !attributes.face_properties.empty()) {
    std::string names;
    for (const MeshAttributes::Property& property : attributes.face_properties)
      names += (names.empty() ? "" : ", ") + property.name;
    losses.push_back(concat("values per face (", names, ") are dropped; use .ply to keep them"));
  }
  if (format == MeshFormat::Obj) return losses;
  if (has_labels(attributes.objects) || has_labels(attributes.groups) || has_labels(attributes.materials))
    losses.emplace_back("objects, groups and materials are dropped; use .obj to keep them");
  if (format != MeshFormat::Ply && attributes.texture_corners.rows() > 0)
    losses.emplace_back("texture coordinates are dropped; use .obj or .ply to keep them");
  return losses;
}

MeshAttributes carried_attributes(const MeshFile& from, const TriangleMesh& to,
                                  std::vector<std::string>& dropped, const Progress& progress) {
  MeshAttributes result = from.attributes;
  const bool has_texture = result.texture_corners.rows() > 0;
  if (!has_texture && result.face_values.empty() && !has_labels(result.objects) &&
      !has_labels(result.groups) && !has_labels(result.materials))
    return result;
  const Eigen::Index m = to.n_triangles();
  Points centres(m, 3);
  for (Eigen::Index f = 0; f < m; ++f)
    centres.row(f) = (to.positions.row(to.triangles(f, 0)) + to.positions.row(to.triangles(f, 1)) +
                      to.positions.row(to.triangles(f, 2))) /
                     3;
  const std::vector<ClosestPoint> closest =
      TriangleTree(from.mesh.positions, from.mesh.triangles).closest(centres, progress);
  std::vector<Eigen::Index> source;
  for (const ClosestPoint& point : closest) source.push_back(point.element);
  for (Eigen::VectorXd& values : result.face_values) values = Eigen::VectorXd(values(source));
  for (MeshAttributes::Labels* labels : {&result.objects, &result.groups, &result.materials}) {
    if (!has_labels(*labels)) continue;
    std::vector<int> of_face;
    for (const Eigen::Index f : source) of_face.push_back(labels->of_face[static_cast<std::size_t>(f)]);
    labels->of_face = std::move(of_face);
  }
  if (!has_texture) return result;
  result.texture_corners.resize(m, 3);
  Eigen::Index lost = 0;
  for (Eigen::Index f = 0; f < m; ++f)
    if (!same_corners(from, source[static_cast<std::size_t>(f)], to, f, result.texture_corners)) {
      result.texture_corners.row(f).setConstant(-1);
      ++lost;
    }
  if (lost > 0)
    dropped.push_back(concat("texture coordinates of ", lost, " of ", m,
                             " triangles, which the input does not have, are dropped"));
  if (lost == m) result.texture_corners.resize(0, 3);
  return result;
}

}  // namespace batten
