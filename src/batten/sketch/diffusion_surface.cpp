// Based on H 6.4: refinement as Catmull–Clark splits, STEP 1 and STEP 2 of 6.4.1, with the scalar form of
// (6.3) and the signs of docs/departures.md.
#include "batten/sketch/diffusion_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/operators/laplacian.hpp"
#include "batten/sketch/refined_mesh_detail.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {

namespace {

/// Share of the size by which drawn curves may move; they are held softly (λ = 1) and move by per mille.
constexpr double kFarthestFromCurves = 0.05;

using Eigen::Index;
using Eigen::Vector3d;

size_t at(int i) {
  return static_cast<size_t>(i);
}

/// A grid of vertices over one quad of the first split; entry (i, j) of (m + 1)².
using Grid = Eigen::MatrixXi;

/// Builds the refined mesh, piece by piece.
class Refiner {
 public:
  Refiner(const PolylineMesh& mesh, int splits) : mesh_(mesh), half_(1 << (splits - 1)) {}

  void run(DiffusionSurface& surface) {
    vertex_of_.assign(mesh_.vertices().size(), -1);
    for (size_t v = 0; v < mesh_.vertices().size(); ++v)
      if (mesh_.vertices()[v].alive) vertex_of_[v] = add(mesh_.vertices()[v].position, true);
    surface.vertices_of_edge.resize(mesh_.edges().size());
    const int n = 2 * half_;
    for (size_t e = 0; e < mesh_.edges().size(); ++e) {
      const SketchEdge& edge = mesh_.edges()[e];
      if (!edge.alive) continue;
      std::vector<int>& chain = surface.vertices_of_edge[e];
      const Points samples = edge.polyline->sampled(n);
      chain.push_back(vertex_of_[at(edge.vertices[0])]);
      for (int k = 1; k < n; ++k) chain.push_back(add(samples.row(k), edge.drawn));
      chain.push_back(vertex_of_[at(edge.vertices[1])]);
      if (edge.sharpness > 0)
        for (int k = 0; k < n; ++k)
          surface.refined.sharp_edges.push_back(
              {chain[at(k)], chain[at(k + 1)], edge.sharpness >= 1 ? kInfinitelySharp : 4 * edge.sharpness});
    }
    for (size_t f = 0; f < mesh_.faces().size(); ++f)
      if (mesh_.faces()[f].alive) refine_face(static_cast<int>(f), surface);
    Points positions(static_cast<Index>(positions_.size()), 3);
    for (size_t v = 0; v < positions_.size(); ++v)
      positions.row(static_cast<Index>(v)) = positions_[v].transpose();
    surface.refined.mesh.positions = std::move(positions);
    surface.on_curve = std::move(held_);
  }

 private:
  int add(const Vector3d& position, bool held) {
    positions_.push_back(position);
    held_.push_back(held ? 1 : 0);
    return static_cast<int>(positions_.size()) - 1;
  }

  /// The vertices along a side, in its sense.
  std::vector<int> along(int side, const DiffusionSurface& surface) const {
    std::vector<int> chain = surface.vertices_of_edge[at(edge_of(side))];
    if (side & 1) std::reverse(chain.begin(), chain.end());
    return chain;
  }

  void refine_face(int face, DiffusionSurface& surface) {
    const std::vector<int>& sides = mesh_.face(face).sides;
    const auto n = sides.size();
    std::vector<std::vector<int>> chains;
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    for (const int side : sides) {
      chains.push_back(along(side, surface));
      for (size_t k = 0; k + 1 < chains.back().size(); ++k, ++count) sum += positions_[at(chains.back()[k])];
    }
    const int centre = add(sum / count, false);
    // Spokes from the middle of each side to the centroid.
    std::vector<std::vector<int>> spokes(n);
    for (size_t k = 0; k < n; ++k) {
      const int middle = chains[k][at(half_)];
      spokes[k].push_back(middle);
      for (int i = 1; i < half_; ++i) {
        const double t = static_cast<double>(i) / half_;
        spokes[k].push_back(add((1 - t) * positions_[at(middle)] + t * positions_[at(centre)], false));
      }
      spokes[k].push_back(centre);
    }
    for (size_t k = 0; k < n; ++k) {  // the quad at the start of side k
      const size_t before = (k + n - 1) % n;
      Grid grid(half_ + 1, half_ + 1);  // i along side k, j along the side before, backwards
      for (int i = 0; i <= half_; ++i) {
        grid(i, 0) = chains[k][at(i)];
        grid(0, i) = chains[before][chains[before].size() - 1 - at(i)];
        grid(half_, i) = spokes[k][at(i)];
        grid(i, half_) = spokes[before][at(i)];
      }
      fill(grid);
      PolygonMesh& mesh = surface.refined.mesh;
      for (int j = 0; j < half_; ++j)
        for (int i = 0; i < half_; ++i) {
          for (const int v : {grid(i, j), grid(i + 1, j), grid(i + 1, j + 1), grid(i, j + 1)})
            mesh.corners.push_back(v);
          mesh.offsets.push_back(static_cast<int>(mesh.corners.size()));
          surface.face_of_quad.push_back(face);
        }
    }
  }

  /// Inner vertices of a grid from its four sides (bilinearly blended, H 6.1.2): a start for the flow.
  void fill(Grid& grid) {
    const auto m = static_cast<int>(grid.rows()) - 1;
    const auto p = [&](int i, int j) { return positions_[at(grid(i, j))]; };
    for (int j = 1; j < m; ++j)
      for (int i = 1; i < m; ++i) {
        const double u = static_cast<double>(i) / m, v = static_cast<double>(j) / m;
        const Vector3d position = (1 - v) * p(i, 0) + v * p(i, m) + (1 - u) * p(0, j) + u * p(m, j) -
                                  (1 - u) * (1 - v) * p(0, 0) - u * (1 - v) * p(m, 0) -
                                  (1 - u) * v * p(0, m) - u * v * p(m, m);
        grid(i, j) = add(position, false);
      }
  }

  const PolylineMesh& mesh_;
  int half_;
  std::vector<int> vertex_of_;
  std::vector<Vector3d> positions_;
  std::vector<char> held_;
};

/// Every quad cut along the diagonal that leads from the corner of its face towards the centroid: of the ways
/// to cut, the one that brings great circles nearest to a sphere (largest error of the radius at 16 n quads
/// below 0.5 %; 1.1 % with the other diagonal, 0.6 % with the mean of both).
Triangles cut_quads(const PolygonMesh& mesh) {
  Triangles triangles(2 * mesh.n_faces(), 3);
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    const int* c = &mesh.corners[at(mesh.offsets[static_cast<size_t>(f)])];
    triangles.row(2 * f) << c[0], c[1], c[2];
    triangles.row(2 * f + 1) << c[0], c[2], c[3];
  }
  return triangles;
}

std::vector<char> border_vertices(const PolygonMesh& mesh) {
  std::map<std::pair<int, int>, int> sides;
  for (Index f = 0; f < mesh.n_faces(); ++f)
    for (int k = 0; k < 4; ++k) {
      const int a = mesh.corners[at(mesh.offsets[static_cast<size_t>(f)] + k)];
      const int b = mesh.corners[at(mesh.offsets[static_cast<size_t>(f)] + (k + 1) % 4)];
      ++sides[{std::min(a, b), std::max(a, b)}];
    }
  std::vector<char> border(static_cast<size_t>(mesh.positions.rows()), 0);
  for (const auto& [edge, n] : sides)
    if (n == 1) border[at(edge.first)] = border[at(edge.second)] = 1;
  return border;
}

/// S(X) of H 6.4: the sum of the sharpness of the edges at each vertex. The tip of a dart (S ≤ 1) stays
/// smooth.
std::vector<double> vertex_sharpness(const PolylineMesh& mesh, const DiffusionSurface& surface) {
  std::vector<double> sharpness(static_cast<size_t>(surface.refined.mesh.positions.rows()), 0);
  for (size_t e = 0; e < mesh.edges().size(); ++e) {
    const std::vector<int>& chain = surface.vertices_of_edge[e];
    for (size_t k = 0; k < chain.size(); ++k)
      sharpness[at(chain[k])] += (k == 0 || k + 1 == chain.size() ? 1 : 2) * mesh.edges()[e].sharpness;
  }
  for (double& s : sharpness)
    if (s <= 1) s = 0;
  return sharpness;
}

/// The flow of H 6.4.1.
class Flow {
 public:
  Flow(DiffusionSurface& surface, std::vector<double> sharpness, const DiffusionOptions& options)
      : surface_(surface),
        options_(options),
        sharpness_(std::move(sharpness)),
        triangles_(cut_quads(surface.refined.mesh)),
        n_(surface.refined.mesh.positions.rows()),
        border_(border_vertices(surface.refined.mesh)),
        diffusion_("diffusion of mean curvature"),
        refit_("refit to mean curvature") {
    index_.assign(static_cast<size_t>(n_), -1);
    for (Index v = 0; v < n_; ++v)
      if (!held(v)) index_[static_cast<size_t>(v)] = n_unknown_++;
  }

  /// One round. @return the largest move of a vertex.
  double step() {
    Points& X = surface_.refined.mesh.positions;
    const SparseMatrix K = cotangent_stiffness(X, triangles_);
    const Eigen::VectorXd M = lumped_mass(X, triangles_);
    const double mean_area = M.mean();
    if (!(M.minCoeff() > 1e-14 * mean_area))
      throw InvalidInput("the faces leave a quad without area; draw the curves apart, or use fewer splits");
    const Points N = vertex_normals(X, triangles_);
    const Points curvature = K * X;
    Eigen::VectorXd H(n_);
    for (Index v = 0; v < n_; ++v) H(v) = N.row(v).dot(curvature.row(v)) / (2 * M(v));

    // STEP 1: (M/Ā + τ K_w) H⁺ = (M/Ā) H, with the weights (6.5) on the edges.
    diffuse(K, M / mean_area, H);

    // STEP 2: L X = 2 Ā H N in least squares, L = Ā M⁻¹ K, rows weighted by how smooth the vertex is.
    Eigen::VectorXd row(n_);
    for (Index v = 0; v < n_; ++v)
      row(v) = border_[static_cast<size_t>(v)] ? 0 : similarity(sharpness_[static_cast<size_t>(v)], 0);
    SparseMatrix L = (row.array() * mean_area / M.array()).matrix().asDiagonal() * K;
    Points right = (row.array() * 2 * mean_area * H.array()).matrix().asDiagonal() * N;
    std::vector<Eigen::Triplet<double>> selection;
    for (Index v = 0; v < n_; ++v) {
      const int u = index_[static_cast<size_t>(v)];
      if (u >= 0) selection.emplace_back(v, u, 1.0);
    }
    SparseMatrix free(n_, n_unknown_);
    free.setFromTriplets(selection.begin(), selection.end());
    Points known = X;
    for (Index v = 0; v < n_; ++v)
      if (index_[static_cast<size_t>(v)] >= 0) known.row(v).setZero();
    right -= L * known;
    const SparseMatrix A = L * free;
    SparseMatrix normal = A.transpose() * A;
    Eigen::MatrixXd b = A.transpose() * right;
    // Where creases on all sides leave a vertex no row of its own, it stays where it is.
    const double anchor = 1e-10;
    for (Index v = 0; v < n_; ++v) {
      const int u = index_[static_cast<size_t>(v)];
      if (u < 0) continue;
      double weight = anchor;
      Vector3d target = X.row(v);
      if (surface_.on_curve[static_cast<size_t>(v)]) {  // λ > 0: held softly
        weight = options_.fidelity;
        target = start_.row(v);
      }
      normal.coeffRef(u, u) += weight;
      b.row(u) += weight * target.transpose();
    }
    refit_.factorize(normal);
    const Eigen::MatrixXd solved = refit_.solve(b);
    double move = 0;
    for (Index v = 0; v < n_; ++v) {
      const int u = index_[static_cast<size_t>(v)];
      if (u < 0) continue;
      move = std::max(move, (solved.row(u) - X.row(v)).norm());
      X.row(v) = solved.row(u);
    }
    return move;
  }

  void remember_start() { start_ = surface_.refined.mesh.positions; }

 private:
  /// Border vertices are held in any case: nothing else says where they belong.
  bool held(Index v) const {
    return border_[static_cast<size_t>(v)] ||
           (surface_.on_curve[static_cast<size_t>(v)] && options_.fidelity == 0);
  }

  double similarity(double s, double t) const {  // (6.5): D is not squared, σ is
    return std::exp(-std::abs(s - t) / (options_.similarity * options_.similarity));
  }

  void diffuse(const SparseMatrix& K, const Eigen::VectorXd& mass, Eigen::VectorXd& H) {
    std::vector<Eigen::Triplet<double>> entries;
    for (Index j = 0; j < K.outerSize(); ++j)
      for (SparseMatrix::InnerIterator entry(K, j); entry; ++entry) {
        const Index i = entry.row();
        if (i >= j) continue;
        // Obtuse triangles have edges of the other sign: curvature would flow uphill there, and the matrix
        // need not be positive.
        double weight = options_.time_step * std::min(0.0, entry.value()) *
                        similarity(sharpness_[static_cast<size_t>(i)], sharpness_[static_cast<size_t>(j)]);
        // The curvature of border vertices is not known; none flows there.
        if (border_[static_cast<size_t>(i)] || border_[static_cast<size_t>(j)]) weight = 0;
        entries.emplace_back(j, i, weight);
        entries.emplace_back(i, i, -weight);
        entries.emplace_back(j, j, -weight);
      }
    for (Index v = 0; v < n_; ++v) entries.emplace_back(v, v, mass(v));
    SparseMatrix A(n_, n_);
    A.setFromTriplets(entries.begin(), entries.end());
    diffusion_.factorize(A);
    for (int k = 0; k < options_.diffusion_steps; ++k) H = diffusion_.solve(mass.cwiseProduct(H));
  }

  DiffusionSurface& surface_;
  const DiffusionOptions& options_;
  std::vector<double> sharpness_;
  Triangles triangles_;
  Index n_;
  std::vector<char> border_;
  std::vector<int> index_;  ///< per vertex its unknown, or −1
  int n_unknown_ = 0;
  Points start_;
  SparseCholesky diffusion_, refit_;
};

/// Limit points of Catmull–Clark at the vertices of a quad mesh, with creases and borders (Halstead, Kass and
/// DeRose 1993; Biermann, Levin and Zorin 2000): weights as one sparse matrix.
SparseMatrix limit_stencils(const ControlCage& cage) {
  const PolygonMesh& mesh = cage.mesh;
  const Index n = mesh.positions.rows();
  std::map<std::pair<int, int>, double> sharp;
  for (const SharpEdge& edge : cage.sharp_edges)
    sharp[{std::min(edge.from, edge.to), std::max(edge.from, edge.to)}] = edge.sharpness;
  std::map<std::pair<int, int>, int> faces_at;
  std::vector<std::vector<int>> opposite(static_cast<size_t>(n));
  std::vector<int> n_faces(static_cast<size_t>(n), 0);
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    const int* c = &mesh.corners[at(mesh.offsets[static_cast<size_t>(f)])];
    for (int k = 0; k < 4; ++k) {
      ++faces_at[{std::min(c[k], c[(k + 1) % 4]), std::max(c[k], c[(k + 1) % 4])}];
      opposite[at(c[k])].push_back(c[(k + 2) % 4]);
      ++n_faces[at(c[k])];
    }
  }
  std::vector<std::vector<int>> neighbours(static_cast<size_t>(n)), creases(static_cast<size_t>(n));
  for (const auto& [edge, count] : faces_at) {
    neighbours[at(edge.first)].push_back(edge.second);
    neighbours[at(edge.second)].push_back(edge.first);
    const auto found = sharp.find(edge);
    if (count == 1 || (found != sharp.end() && found->second >= 2)) {
      creases[at(edge.first)].push_back(edge.second);
      creases[at(edge.second)].push_back(edge.first);
    }
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (Index v = 0; v < n; ++v) {
    const auto i = static_cast<size_t>(v);
    if (creases[i].size() > 2 || (n_faces[i] == 1 && creases[i].size() == 2)) {
      entries.emplace_back(v, v, 1);
    } else if (creases[i].size() == 2) {
      entries.emplace_back(v, v, 2.0 / 3);
      for (const int w : creases[i]) entries.emplace_back(v, w, 1.0 / 6);
    } else if (neighbours[i].size() == 2) {  // the general weights are not those of the rules for two edges
      entries.emplace_back(v, v, 1.0 / 8);
      for (const int w : neighbours[i]) entries.emplace_back(v, w, 3.0 / 8);
      for (const int w : opposite[i]) entries.emplace_back(v, w, 1.0 / 16);
    } else {
      const double k = static_cast<double>(neighbours[i].size()), share = 1 / (k * (k + 5));
      entries.emplace_back(v, v, k * k * share);
      for (const int w : neighbours[i]) entries.emplace_back(v, w, 4 * share);
      for (const int w : opposite[i]) entries.emplace_back(v, w, share);
    }
  }
  SparseMatrix stencils(n, n);
  stencils.setFromTriplets(entries.begin(), entries.end());
  return stencils;
}

}  // namespace

// The stencils above hold but for darts and semi-sharp creases: their inverse is applied to what the true
// limit points still lack.
void detail::fit_limit(ControlCage& cage, const Points& target, const Progress& progress) {
  const SparseMatrix stencils = limit_stencils(cage);
  SparseCholesky inverse("cage of the limit surface");
  inverse.factorize(SparseMatrix(stencils.transpose() * stencils));
  const Index n = target.rows();
  const double size = bounding_box_diagonal(target);
  Subdivision limit(cage, {.levels = 0, .limit = true}, progress);
  for (int k = 0; k < 30; ++k) {
    const Points lack = target - limit.surface().limit_positions.topRows(n);
    if (lack.rowwise().norm().maxCoeff() < 1e-10 * size) break;
    cage.mesh.positions += inverse.solve(Eigen::MatrixXd(stencils.transpose() * lack));
    limit.move(cage.mesh.positions, progress);
  }
}

// The flow has no bound on faces that are far from convex or long and thin: what comes out folded is
// refused.
void detail::require_sound(const PolygonMesh& mesh, const std::vector<int>& face_of_quad,
                           const std::vector<char>& on_curve, const Points& start) {
  const Points& positions = mesh.positions;
  const auto face_of = [&](int triangle) { return face_of_quad[at(triangle) / 2]; };
  if (positions.allFinite()) {
    const auto crossing = self_intersections(positions, cut_quads(mesh), 1);
    if (!crossing.empty())
      throw InvalidInput(
          concat("the surface folds or crosses itself in the faces f", face_of(crossing[0].first), " and f",
                 face_of(crossing[0].second),
                 "; divide them by another curve, best where they are not convex or are long and thin"));
  }
  const double size = bounding_box_diagonal(start);
  for (Index v = 0; v < positions.rows(); ++v)
    if (on_curve[static_cast<size_t>(v)] &&
        !((positions.row(v) - start.row(v)).norm() <= kFarthestFromCurves * size))
      throw InvalidInput(
          concat("the surface leaves its curves by more than ", 100 * kFarthestFromCurves,
                 " % of the size; divide the faces by another curve, best where they are not convex"));
}

void detail::turn_outwards(const PolylineMesh& model, PolygonMesh& mesh,
                           const std::vector<int>& face_of_quad) {
  std::vector<int> component(model.faces().size(), -1);
  std::vector<char> is_open;
  for (size_t f = 0; f < model.faces().size(); ++f) {
    if (!model.faces()[f].alive || component[f] >= 0) continue;
    const int own = static_cast<int>(is_open.size());
    is_open.push_back(0);
    std::vector<int> stack{static_cast<int>(f)};
    component[f] = own;
    while (!stack.empty()) {
      const int face = stack.back();
      stack.pop_back();
      for (const int side : model.face(face).sides) {
        const int next = model.face_of(opposite_side(side));
        if (next < 0) is_open.back() = 1;
        if (next < 0 || component[at(next)] >= 0) continue;
        component[at(next)] = own;
        stack.push_back(next);
      }
    }
  }
  std::vector<double> volume(is_open.size(), 0);
  const auto quad = [&](Index f) { return &mesh.corners[at(mesh.offsets[static_cast<size_t>(f)])]; };
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    const int* c = quad(f);
    const auto p = [&](int k) -> Vector3d { return mesh.positions.row(c[k]); };
    const int own = component[at(face_of_quad[static_cast<size_t>(f)])];
    volume[at(own)] += p(0).cross(p(1)).dot(p(2)) + p(0).cross(p(2)).dot(p(3));
  }
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    const int own = component[at(face_of_quad[static_cast<size_t>(f)])];
    if (is_open[at(own)] || volume[at(own)] >= 0) continue;
    int* c = quad(f);
    std::swap(c[1], c[3]);
  }
}

std::optional<std::string> DiffusionOptions::problem() const {
  if (splits < 1 || splits > 6) return concat("splits must be 1 to 6, got ", splits);
  if (rounds < 0 || rounds > 50) return concat("rounds must be 0 to 50, got ", rounds);
  if (!(time_step > 0) || !std::isfinite(time_step))
    return concat("time_step must be above 0, got ", time_step);
  if (diffusion_steps < 1 || diffusion_steps > 1000)
    return concat("diffusion_steps must be 1 to 1000, got ", diffusion_steps);
  if (!(similarity > 0) || !std::isfinite(similarity))
    return concat("similarity must be above 0, got ", similarity);
  if (!(fidelity >= 0) || !std::isfinite(fidelity))
    return concat("fidelity must be at least 0, got ", fidelity);
  return std::nullopt;
}

DiffusionSurface diffusion_surface(const PolylineMesh& mesh, const DiffusionOptions& options,
                                   const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  double quads = 0;
  for (const SketchFace& face : mesh.faces()) quads += static_cast<double>(face.sides.size());
  quads *= std::pow(4.0, options.splits - 1);
  if (quads == 0) throw InvalidInput("the model has no faces; insert a closed curve first");
  if (quads > 2e6)
    throw InvalidInput(concat("the refined mesh would have ", quads, " quads; use fewer splits"));
  DiffusionSurface surface;
  {
    const ScopedStage stage(surface.times, "refine");
    Refiner(mesh, options.splits).run(surface);
    detail::turn_outwards(mesh, surface.refined.mesh, surface.face_of_quad);
  }
  const Points start = surface.refined.mesh.positions;
  {
    const ScopedStage stage(surface.times, "flow");
    Flow flow(surface, vertex_sharpness(mesh, surface), options);
    flow.remember_start();
    const double size = bounding_box_diagonal(surface.refined.mesh.positions);
    for (int round = 0; round < options.rounds; ++round) {
      progress.report("flow", static_cast<double>(round) / options.rounds);
      surface.last_move = flow.step() / size;
      if (surface.last_move < 1e-9) break;
    }
  }
  detail::require_sound(surface.refined.mesh, surface.face_of_quad, surface.on_curve, start);
  const ScopedStage stage(surface.times, "cage");
  surface.cage = surface.refined;
  detail::fit_limit(surface.cage, surface.refined.mesh.positions, progress);
  return surface;
}

}  // namespace batten
