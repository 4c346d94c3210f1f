#include "batten/render/rasteriser.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/text.hpp"

namespace batten {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr int kBandRows = 16;  ///< rows of pixels that one thread draws at a time
constexpr int kNothing = -1;
/// Tubes are lifted by this part of their radius, so that curves drawn on a surface are not half sunk in it.
constexpr double kLift = 0.5;

/// Items by the bands of rows that they touch, in the order of the items.
class Bands {
 public:
  Bands(int n_bands, double rows_per_band) : rows_(rows_per_band), first_(n_bands + 1, 0) {}

  /// Twice over all items: count, then fill.
  template <typename Visit>
  void sort(std::size_t n, const Visit& extent) {
    for (std::size_t i = 0; i < n; ++i) each(extent(i), [&](int band) { ++first_[band + 1]; });
    for (std::size_t b = 1; b < first_.size(); ++b) first_[b] += first_[b - 1];
    items_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < n; ++i)
      each(extent(i), [&](int band) { items_[next[band]++] = static_cast<int>(i); });
  }
  const int* begin(int band) const { return items_.data() + first_[band]; }
  const int* end(int band) const { return items_.data() + first_[band + 1]; }

 private:
  template <typename Use>
  void each(const std::pair<double, double>& rows, const Use& use) const {
    const int n = static_cast<int>(first_.size()) - 1;
    if (!(rows.second >= 0) || !(rows.first < n * rows_)) return;
    const int from = std::max(0, static_cast<int>(rows.first / rows_));
    const int to = std::min(n - 1, static_cast<int>(std::min(rows.second / rows_, 1e9)));
    for (int band = from; band <= to; ++band) use(band);
  }

  double rows_;
  std::vector<std::size_t> first_;
  std::vector<int> items_;
};

/// The nearest thing per sample of a band.
struct Buffer {
  int width, height, first_row;  ///< in samples
  std::vector<float> depth;
  std::vector<int> item;

  Buffer(int w, int h, int first)
      : width(w),
        height(h),
        first_row(first),
        depth(static_cast<std::size_t>(w) * h, -std::numeric_limits<float>::infinity()),
        item(static_cast<std::size_t>(w) * h, kNothing) {}

  void put(int x, int row, float d, int i) {
    const std::size_t at = static_cast<std::size_t>(row) * width + x;
    if (d > depth[at]) {
      depth[at] = d;
      item[at] = i;
    }
  }
};

/// Fills a triangle given in samples (x, y, depth), row by row between its edges.
void fill_triangle(Buffer& buffer, const Vector3d& a, const Vector3d& b, const Vector3d& c, int item) {
  const double area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  if (!(std::abs(area) > 0)) return;
  const double depth_x = ((b.z() - a.z()) * (c.y() - a.y()) - (c.z() - a.z()) * (b.y() - a.y())) / area;
  const double depth_y = ((c.z() - a.z()) * (b.x() - a.x()) - (b.z() - a.z()) * (c.x() - a.x())) / area;
  const double low = std::min({a.y(), b.y(), c.y()}), high = std::max({a.y(), b.y(), c.y()});
  const int from = std::max(buffer.first_row, static_cast<int>(std::ceil(low - 0.5)));
  const int to = std::min(buffer.first_row + buffer.height - 1, static_cast<int>(std::floor(high - 0.5)));
  const Vector3d* corners[3] = {&a, &b, &c};
  for (int row = from; row <= to; ++row) {
    const double y = row + 0.5;
    double left = std::numeric_limits<double>::infinity(), right = -left;
    for (int k = 0; k < 3; ++k) {
      const Vector3d* p = corners[k];
      const Vector3d* q = corners[(k + 1) % 3];
      // The same arithmetic from both sides of an edge, so that neighbours leave no gap.
      if (q->y() < p->y() || (q->y() == p->y() && q->x() < p->x())) std::swap(p, q);
      if (y < p->y() || y > q->y()) continue;
      const double t = q->y() > p->y() ? (y - p->y()) / (q->y() - p->y()) : 0.0;
      const double x = p->x() + t * (q->x() - p->x());
      left = std::min(left, x);
      right = std::max(right, x);
      if (q->y() == p->y()) right = std::max(right, q->x());
    }
    if (!(left <= right)) continue;
    const int x0 = static_cast<int>(std::max(0.0, std::ceil(left - 0.5)));
    const int x1 = static_cast<int>(std::min(buffer.width - 1.0, std::floor(right - 0.5)));
    double depth = a.z() + depth_x * (x0 + 0.5 - a.x()) + depth_y * (y - a.y());
    for (int x = x0; x <= x1; ++x, depth += depth_x)
      buffer.put(x, row - buffer.first_row, static_cast<float>(depth), item);
  }
}

/// A tube in the picture: ends and radius in samples, depth and camera z at the ends.
struct FlatTube {
  Vector2d a, ab;
  Vector3d camera_a, camera_b;
  double radius;
};

/// Where along (0 … 1) and how far across (0 … 1) a sample lies; false when outside.
bool across_tube(const FlatTube& tube, const Vector2d& p, double& along, double& across) {
  const double length2 = tube.ab.squaredNorm();
  along = length2 > 0 ? std::clamp(tube.ab.dot(p - tube.a) / length2, 0.0, 1.0) : 0.0;
  across = (p - tube.a - along * tube.ab).norm() / tube.radius;
  return across <= 1;
}

/// The point of the axis in camera coordinates, moved towards the viewer to the surface of the lifted tube.
Vector3d on_tube(const FlatTube& tube, const PictureCamera& camera, int samples, double along,
                 double across) {
  const Vector3d axis = (1 - along) * tube.camera_a + along * tube.camera_b;
  const double radius = tube.radius / samples * camera.pixel_size(axis);
  return axis +
         (kLift + std::sqrt(std::max(0.0, 1 - across * across))) * radius * camera.towards_viewer(axis);
}

void fill_tube(Buffer& buffer, const FlatTube& tube, const PictureCamera& camera, int samples, int item) {
  const Vector2d b = tube.a + tube.ab;
  const int x0 = static_cast<int>(std::max(0.0, std::floor(std::min(tube.a.x(), b.x()) - tube.radius)));
  const int x1 =
      static_cast<int>(std::min(buffer.width - 1.0, std::ceil(std::max(tube.a.x(), b.x()) + tube.radius)));
  const int y0 = static_cast<int>(
      std::max<double>(buffer.first_row, std::floor(std::min(tube.a.y(), b.y()) - tube.radius)));
  const int y1 = static_cast<int>(std::min<double>(buffer.first_row + buffer.height - 1,
                                                   std::ceil(std::max(tube.a.y(), b.y()) + tube.radius)));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      double along = 0, across = 0;
      if (!across_tube(tube, Vector2d(x + 0.5, y + 0.5), along, across)) continue;
      const Vector3d surface = on_tube(tube, camera, samples, along, across);
      buffer.put(x, y - buffer.first_row, static_cast<float>(camera.project(surface).z()), item);
    }
}

/// A scene as one camera sees it, drawn in bands of rows.
class Rasteriser {
 public:
  Rasteriser(const Scene& scene, const PictureCamera& camera, int samples)
      : scene_(scene),
        camera_(camera),
        samples_(samples),
        in_camera_(scene.positions.rows(), 3),
        in_picture_(scene.positions.rows(), 3) {
    for (Eigen::Index i = 0; i < scene.positions.rows(); ++i) {
      const Vector3d p = camera.to_camera(scene.positions.row(i));
      const Vector3d q = camera.project(p);
      in_camera_.row(i) = p;
      in_picture_.row(i) << samples * q.x(), samples * q.y(), q.z();
    }
    tubes_.reserve(scene.tubes.size());
    for (const Tube& tube : scene.tubes) {
      const Vector3d a = camera.to_camera(tube.from), b = camera.to_camera(tube.to);
      const Vector2d pa = samples * camera.project(a).head<2>(), pb = samples * camera.project(b).head<2>();
      tubes_.push_back({pa, pb - pa, a, b, samples * tube.radius});
    }
  }

  void draw(Image& image, const Shader& shader, const std::function<Colour(double)>& background) const {
    const int n_bands = (image.height + kBandRows - 1) / kBandRows;
    Bands triangles(n_bands, kBandRows * samples_), tubes(n_bands, kBandRows * samples_);
    triangles.sort(scene_.triangles.rows(), [&](std::size_t t) {
      const double a = corner(t, 0).y(), b = corner(t, 1).y(), c = corner(t, 2).y();
      return std::pair(std::min({a, b, c}) - 1, std::max({a, b, c}) + 1);
    });
    tubes.sort(tubes_.size(), [&](std::size_t i) {
      const double a = tubes_[i].a.y(), b = a + tubes_[i].ab.y();
      return std::pair(std::min(a, b) - tubes_[i].radius - 1, std::max(a, b) + tubes_[i].radius + 1);
    });
    parallel_for(n_bands, 1, [&](Eigen::Index first_band, Eigen::Index last_band) {
      for (auto band = static_cast<int>(first_band); band < last_band; ++band) {
        const int top = band * kBandRows, bottom = std::min(image.height, top + kBandRows);
        Buffer buffer(image.width * samples_, (bottom - top) * samples_, top * samples_);
        for (const int* t = triangles.begin(band); t != triangles.end(band); ++t)
          fill_triangle(buffer, corner(*t, 0), corner(*t, 1), corner(*t, 2), *t);
        for (const int* i = tubes.begin(band); i != tubes.end(band); ++i)
          fill_tube(buffer, tubes_[*i], camera_, samples_, n_triangles() + *i);
        for (int y = top; y < bottom; ++y) shade_row(image, y, buffer, shader, background);
      }
    });
  }

 private:
  int n_triangles() const { return static_cast<int>(scene_.triangles.rows()); }
  Vector3d corner(std::size_t triangle, int k) const {
    return in_picture_.row(scene_.triangles(static_cast<Eigen::Index>(triangle), k));
  }

  void shade_row(Image& image, int y, const Buffer& buffer, const Shader& shader,
                 const std::function<Colour(double)>& background) const {
    const Colour behind = background((y + 0.5) / image.height);
    for (int x = 0; x < image.width; ++x) {
      Colour sum = Colour::Zero();
      for (int sy = 0; sy < samples_; ++sy)
        for (int sx = 0; sx < samples_; ++sx) {
          const int px = x * samples_ + sx, py = y * samples_ + sy;
          const int item = buffer.item[static_cast<std::size_t>(py - buffer.first_row) * buffer.width + px];
          sum += item == kNothing ? behind : shader(hit(item, px, py));
        }
      const Colour mean = sum / static_cast<float>(samples_ * samples_);
      std::uint8_t* pixel = image.at(x, y);
      for (int k = 0; k < 3; ++k) pixel[k] = srgb_byte(mean[k]);
    }
  }

  /// What the middle of a sample shows of the item that covers it.
  Hit hit(int item, int px, int py) const {
    Hit hit;
    if (item < n_triangles())
      hit_triangle(item, (px + 0.5) / samples_, (py + 0.5) / samples_, hit);
    else
      hit_tube(item - n_triangles(), px + 0.5, py + 0.5, hit);
    hit.viewer = camera_.towards_viewer(hit.position);
    hit.pixel_size = camera_.pixel_size(hit.position);
    return hit;
  }

  void hit_triangle(int t, double pixel_x, double pixel_y, Hit& hit) const {
    const Vector3d a = in_camera_.row(scene_.triangles(t, 0)), b = in_camera_.row(scene_.triangles(t, 1)),
                   c = in_camera_.row(scene_.triangles(t, 2));
    Vector3d origin, direction;
    camera_.ray(pixel_x, pixel_y, origin, direction);
    // Signed volumes of the ray with the edges (Plücker); the same sign inside.
    const Vector3d pa = a - origin, pb = b - origin, pc = c - origin;
    Vector3d w(direction.dot(pb.cross(pc)), direction.dot(pc.cross(pa)), direction.dot(pa.cross(pb)));
    const double sum = w.sum();
    w = std::abs(sum) > 0 ? Vector3d((w / sum).cwiseMax(0)) : Vector3d::Constant(1.0 / 3);
    w /= w.sum();
    hit.triangle = t;
    hit.weights = w;
    hit.position = w[0] * a + w[1] * b + w[2] * c;
    hit.normal = (b - a).cross(c - a).normalized();
  }

  void hit_tube(int i, double x, double y, Hit& hit) const {
    const FlatTube& tube = tubes_[i];
    double along = 0, across = 0;
    across_tube(tube, Vector2d(x, y), along, across);
    across = std::min(across, 1.0);
    hit.tube = i;
    hit.weights = Vector3d(1 - along, along, 0);
    hit.position = on_tube(tube, camera_, samples_, along, across);
    const Vector2d aside = (Vector2d(x, y) - tube.a - along * tube.ab) / tube.radius;
    hit.normal = Vector3d(aside.x(), -aside.y(), std::sqrt(1 - across * across)).normalized();
  }

  const Scene& scene_;
  const PictureCamera& camera_;
  int samples_;
  Points in_camera_, in_picture_;  ///< of the vertices; the picture counts samples
  std::vector<FlatTube> tubes_;
};

}  // namespace

void rasterise(Image& image, const Scene& scene, const PictureCamera& camera, int samples,
               const Shader& shader, const std::function<Colour(double)>& background,
               const Progress& progress) {
  if (samples < 1 || samples > 8)
    throw InvalidInput(concat("samples must lie between 1 and 8, got ", samples));
  if (scene.triangles.rows() > 0 &&
      (scene.triangles.minCoeff() < 0 || scene.triangles.maxCoeff() >= scene.positions.rows()))
    throw InvalidInput("a triangle of the picture names a vertex that does not exist");
  progress.report("draw", 0);
  Rasteriser(scene, camera, samples).draw(image, shader, background);
  progress.report("draw", 1);
}

}  // namespace batten
