#include "simulated_scans.hpp"
#include "thesis_s.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/pipeline/network_surface.hpp"
#include "batten/pipeline/shape_comparison.hpp"
#include "batten/scan/reconstruct.hpp"

// The scans of S 3.7 and 5.3.2, of which none is public: five sets of data by five sampling distances by four
// pairs of weights, networks and surfaces.
namespace batten::experiments {

namespace {

/// S: h in per cent of the diameter.
constexpr double kSteps[] = {6.4, 3.2, 1.6, 0.8, 0.4};
constexpr std::size_t kNumberOfSteps = std::size(kSteps);
/// The step at which rows are decided, the default of batten network; S prints figures without naming theirs.
constexpr std::size_t kDecidingStep = 2;
/// Where S's weights are compared as surfaces in a quick run.
constexpr std::size_t kQuickSurfaceStep = 1;

/// S (3.30), lengths in kThesisUnit. `lambda` 0: our default.
struct Weights {
  const char* name;
  double lambda, mu;
};
constexpr Weights kWeights[] = {{"ours, automatic", 0, 0},
                                {"λ = 1, μ = 1", 1, 1},
                                {"λ = 1, μ = 100", 1, 100},
                                {"λ = 100, μ = 1", 100, 1},
                                {"λ = 100, μ = 100", 100, 100}};
constexpr std::size_t kNumberOfWeights = std::size(kWeights);

/// A set of data as S took it.
struct DataSet {
  const char* key;
  const char* figure;  ///< network error
  const char* surface_figure;
  Acquisition acquisition;
  int planes;    ///< of lilium; 0: the cone
  int readings;  ///< S table 3.9
};
constexpr DataSet kCone = {"cone", "3.18", "5.17", Acquisition::Device, 0, 949};
constexpr DataSet kEstimated = {
    "lilium, 5 curves, phone, estimated lengths", "3.19", "5.18", Acquisition::PhoneEstimated, 2, 531};
constexpr DataSet kMeasured = {
    "lilium, 5 curves, phone, measured lengths", "3.20", "5.19", Acquisition::PhoneMeasured, 2, 531};
constexpr DataSet kDevice = {"lilium, 5 curves, device", "3.21", "5.20", Acquisition::Device, 2, 3243};
constexpr DataSet kSevenCurves = {"lilium, 7 curves, device", "3.22", "5.21", Acquisition::Device, 3, 3243};

const double kNone = std::numeric_limits<double>::quiet_NaN();

/// Mean distances from the truth in per cent, over all steps and weights: of one seed.
struct SeedErrors {
  TruthDistances network[kNumberOfSteps][kNumberOfWeights], surface[kNumberOfSteps][kNumberOfWeights];
  int refused = 0, flawed = 0;
};
/// Of all seeds.
class SetErrors {
 public:
  explicit SetErrors(std::vector<SeedErrors> seeds) : seeds_(std::move(seeds)) {}

  Spread network(std::size_t h, std::size_t w) const {
    return spread([&](const SeedErrors& seed) { return seed.network[h][w].mean; });
  }
  Spread surface(std::size_t h, std::size_t w) const {
    return spread([&](const SeedErrors& seed) { return seed.surface[h][w].mean; });
  }
  Spread spread(const std::function<double(const SeedErrors&)>& value) const {
    std::vector<double> values;
    for (const SeedErrors& seed : seeds_) values.push_back(value(seed));
    return spread_of(std::move(values));
  }
  /// What was left out, a sentence; empty where nothing was.
  std::string remark() const {
    int refused = 0, flawed = 0;
    for (const SeedErrors& seed : seeds_) {
      refused += seed.refused;
      flawed += seed.flawed;
    }
    std::string text;
    if (refused > 0) text += concat(refused, " networks or surfaces were refused and are left out. ");
    if (flawed > 0)
      text += concat(flawed, " surfaces fold or cross themselves and are measured all the same. ");
    return text;
  }

 private:
  std::vector<SeedErrors> seeds_;
};

/// λ and μ of S, lengths in kThesisUnit, as options whose lengths are sizes of the scan.
ScanOptions thesis_options(const Weights& weights, double size) {
  const double ratio = kThesisUnit / size;
  ScanOptions options;
  options.weights = WeightChoice::Given;
  options.energy = RegressionEnergy::Thesis;
  options.scheme = IntegrationScheme::Thesis;
  options.robust = false;
  options.lambda = weights.lambda * ratio;
  options.mu = weights.mu * ratio * ratio * ratio;
  return options;
}

double length_of(const CurveNetwork& network) {
  double length = 0;
  for (const NetworkCurve& curve : network.curves)
    for (std::size_t k = 0; k + 1 < curve.vertices.size(); ++k)
      length +=
          (network.positions.row(curve.vertices[k + 1]) - network.positions.row(curve.vertices[k])).norm();
  return length;
}

/// Which surfaces are made: all take hours.
bool makes_surface(bool quick, std::size_t h, std::size_t w) {
  if (quick) return w == 0 ? h == kDecidingStep || h == kQuickSurfaceStep : h == kQuickSurfaceStep;
  return h <= kDecidingStep;
}

SeedErrors measured_seed(const DataSet& set, const ScannedObject& object, bool quick, bool with_surfaces,
                         int seed) {
  SeedErrors errors;
  for (std::size_t h = 0; h < kNumberOfSteps; ++h)
    for (std::size_t w = 0; w < kNumberOfWeights; ++w)
      errors.network[h][w] = errors.surface[h][w] = {kNone, kNone, kNone, kNone};
  const double true_length = total_length(object.traced);
  ReconstructionSolver solver(
      acquired_scan(object, set.acquisition, set.readings, static_cast<std::uint64_t>(seed)));
  for (std::size_t h = 0; h < kNumberOfSteps; ++h) {
    if (quick && h > kDecidingStep) continue;
    double size = object.truth.diameter;
    for (std::size_t w = 0; w < kNumberOfWeights; ++w) {
      try {
        ScanOptions options = w == 0 ? ScanOptions{} : thesis_options(kWeights[w], size);
        options.step = Length{kSteps[h] / 100 * object.truth.diameter, Length::Kind::Plain};
        if (w == 0 && set.acquisition != Acquisition::Device) options.lengths = LengthChoice::Estimated;
        ScanNetwork made = solver.solve(options);
        if (w == 0) size = made.report.size;
        // S 3.7.3: networks of estimated lengths are scaled to the total length that is measured.
        if (set.acquisition == Acquisition::PhoneEstimated)
          made.network.positions *= true_length / length_of(made.network);
        errors.network[h][w] = distances_from_truth(shape_of(made.network), object.truth);
        if (!with_surfaces || !makes_surface(quick, h, w)) continue;
        const NetworkSurface surface = network_surface(made.network);
        if (!surface.is_sound()) ++errors.flawed;
        errors.surface[h][w] = distances_from_truth(shape_of(surface.mesh), object.truth);
      } catch (const Cancelled&) {
        throw;
      } catch (const Error&) {
        ++errors.refused;
      }
    }
  }
  return errors;
}

/// The sets of data, each measured when it is first asked for.
class AcquiredData {
 public:
  const ScannedObject* object(ThesisRun& run, const DataSet& set) {
    auto& object = objects_[set.planes];
    if (object) return object.get();
    if (set.planes == 0) {
      object = std::make_unique<ScannedObject>(scanned_cone());
    } else if (const TriangleMesh* lilium = run.mesh("lilium")) {
      object = std::make_unique<ScannedObject>(scanned_lilium(*lilium, set.planes));
    }
    return object.get();
  }
  /// Null where the object is not at hand.
  const SetErrors* errors(ThesisRun& run, const DataSet& set) {
    const auto known = errors_.find(set.key);
    if (known != errors_.end()) return &known->second;
    const ScannedObject* scanned = object(run, set);
    if (scanned == nullptr) return nullptr;
    const bool with_surfaces = run.wants(concat("S ", set.surface_figure)) || run.wants("S 4.19");
    auto seeds = run.for_seeds(
        [&](int seed) { return measured_seed(set, *scanned, run.options.quick, with_surfaces, seed); });
    return &errors_.emplace(set.key, std::move(seeds)).first->second;
  }

 private:
  std::map<int, std::unique_ptr<ScannedObject>> objects_;
  std::map<std::string, SetErrors> errors_;
};

std::string spread_text(const Spread& spread) {
  return std::isfinite(spread.median) ? concat(number(spread.median), " / ", number(spread.worst))
                                      : std::string("–");
}

/// Table and plot of mean errors against h, a column for each pair of weights.
void add_error_table(ThesisRow& row, const std::string& title,
                     const std::function<Spread(std::size_t h, std::size_t w)>& errors,
                     std::optional<std::pair<double, std::string>> level) {
  ReportGrid grid;
  grid.title = title;
  grid.note = "Mean distance from the true surface in per cent of the diameter: median / worst of the seeds.";
  grid.columns = {"h, %"};
  ReportPlot plot;
  plot.title = title;
  plot.x = "h, % of the diameter";
  plot.y = "mean distance, %";
  plot.level = std::move(level);
  for (std::size_t w = 0; w < kNumberOfWeights; ++w) {
    grid.columns.emplace_back(kWeights[w].name);
    plot.lines.push_back({kWeights[w].name, {}});
  }
  for (std::size_t h = 0; h < kNumberOfSteps; ++h) {
    std::vector<std::string> cells = {number(kSteps[h])};
    bool any = false;
    for (std::size_t w = 0; w < kNumberOfWeights; ++w) {
      const Spread spread = errors(h, w);
      any = any || std::isfinite(spread.median);
      cells.push_back(spread_text(spread));
      plot.lines[w].points.emplace_back(kSteps[h], spread.median);
    }
    if (any) grid.rows.push_back(std::move(cells));
  }
  row.grids.push_back(std::move(grid));
  row.plots.push_back(std::move(plot));
}

constexpr const char* kWeightsRemark =
    "S's weights with lengths in centimetres, since S does not state its unit. Decided by the median at h = "
    "1.6 "
    "%. ";

std::string data_text(const ThesisRun& run, const DataSet& set) {
  return run.seeds_text(concat("simulated scans of ", set.planes == 0 ? "the cone" : "sections of lilium.obj",
                               ", ", set.readings, " readings"));
}

ThesisRow row_of(ThesisRun& run, AcquiredData& data, const DataSet& set, const std::string& figure,
                 std::string claim) {
  ThesisRow row;
  row.id = "S " + figure;
  row.claim = std::move(claim);
  row.needs = "the recordings of S";
  if (data.object(run, set) == nullptr) row.needs += " and lilium.obj in the folder of --data";
  return row;
}

Json spread_json(const Spread& spread) {
  return {{"median_percent", spread.median}, {"worst_percent", spread.worst}};
}

/// Draws the network of one seed with its distances, and the surface on it.
void draw_seed(ThesisRun& run, AcquiredData& data, const DataSet& set, ThesisRow& row) {
  if (!run.options.pictures || !run.wants(row.id)) return;
  const ScannedObject& object = *data.object(run, set);
  ScanOptions options;
  if (set.acquisition != Acquisition::Device) options.lengths = LengthChoice::Estimated;
  const ScanNetwork made =
      network_from_scan(acquired_scan(object, set.acquisition, set.readings, 1), options);
  NetworkSurface surface = network_surface(made.network);
  TruthErrors errors = truth_errors(shape_of(surface.mesh), object.truth.shape);
  Subject subject{.mesh = &surface.mesh, .network = &made.network};
  subject.errors = errors.vertices;
  subject.error_unit = "% of the diameter";
  for (const Shading shading : {Shading::Error, Shading::Isophotes}) {
    RenderOptions how;
    how.shading = shading;
    how.width = 560;
    how.height = 420;
    run.draw(row, shading == Shading::Error ? "distance from the truth" : "isophotes",
             "Seed 1, h = 1.6 %, automatic weights.", subject, how);
  }
}

/// S 3.18 and 5.17.
void cone(ThesisRun& run, AcquiredData& data) {
  const SetErrors& errors = *data.errors(run, kCone);
  {
    ThesisRow row = row_of(run, data, kCone, kCone.figure,
                           "Cone: the mean error is always around 0.4 %, whatever the weights.");
    row.thesis = {{"mean_percent", 0.4}};
    row.data = data_text(run, kCone);
    row.remark = kWeightsRemark + errors.remark();
    double largest = 0;
    Json ours = Json::object();
    for (std::size_t w = 0; w < kNumberOfWeights; ++w) {
      const Spread spread = errors.network(kDecidingStep, w);
      largest = std::max(largest, std::isfinite(spread.median) ? spread.median : 1e9);
      ours[kWeights[w].name] = spread_json(spread);
    }
    row.ours = ours;
    row.stand_in(largest <= 0.4);
    add_error_table(
        row, "Network error, cone", [&](std::size_t h, std::size_t w) { return errors.network(h, w); },
        std::pair(0.4, "S: always around this"));
    run.add(std::move(row));
  }
  ThesisRow row = row_of(run, data, kCone, kCone.surface_figure,
                         "Cone: the mean error of the surface is smaller than 1 % at the finest step.");
  row.thesis = {{"mean_percent_below", 1}};
  row.data = data_text(run, kCone);
  const Spread ours = errors.surface(kDecidingStep, 0), network = errors.network(kDecidingStep, 0);
  row.ours = {{"surface", spread_json(ours)}, {"network", spread_json(network)}};
  row.remark =
      concat(kWeightsRemark, "Also asked: at most 1.5 times the error of the network. ", errors.remark());
  row.stand_in(ours.median < 1 && ours.median <= 1.5 * network.median);
  add_error_table(row, "Surface error, cone",
                  [&](std::size_t h, std::size_t w) { return errors.surface(h, w); }, {});
  draw_seed(run, data, kCone, row);
  run.add(std::move(row));
}

/// S 3.19 to 3.22 and 5.18 to 5.21.
void lilium(ThesisRun& run, AcquiredData& data, const DataSet& set) {
  const SetErrors* errors = data.errors(run, set);
  const bool is_seven = set.planes == 3;
  const bool large_wins = set.acquisition == Acquisition::PhoneEstimated || is_seven;
  ThesisRow network = row_of(run, data, set, set.figure,
                             concat(set.key, ": the mean error is 1.1 to 1.5 % for reasonable weights."));
  ThesisRow order = row_of(run, data, set, concat(set.figure, " weights"),
                           concat(set.key, ": ", large_wins ? "λ = 100" : "λ = 1", " is better than ",
                                  large_wins ? "λ = 1" : "λ = 100", is_seven ? " by a little." : "."));
  ThesisRow surface = row_of(
      run, data, set, set.surface_figure,
      is_seven
          ? std::string("7 curves: about 1 % where 5 curves gave about 0.85 %; adding curves need not help.")
          : concat(set.key, ": the smallest mean error of the surfaces is 0.62 %."));
  network.thesis = {{"mean_percent", {1.1, 1.5}}};
  order.thesis = {{"better", large_wins ? "λ = 100" : "λ = 1"}};
  surface.thesis =
      is_seven ? Json{{"mean_percent", 1.0}, {"with_5_curves_percent", 0.85}} : Json{{"mean_percent", 0.62}};
  if (errors == nullptr) {
    for (ThesisRow* row : {&network, &order, &surface}) run.add(std::move(*row));
    return;
  }
  for (ThesisRow* row : {&network, &order, &surface}) {
    row->data = data_text(run, set);
    row->remark = kWeightsRemark + errors->remark();
  }
  const Spread ours = errors->network(kDecidingStep, 0);
  network.ours = spread_json(ours);
  network.stand_in(ours.median <= 1.1);
  add_error_table(
      network, concat("Network error, ", set.key),
      [&](std::size_t h, std::size_t w) { return errors->network(h, w); }, std::pair(1.1, "S: 1.1 to 1.5"));
  run.add(std::move(network));

  // The better of both μ for either λ.
  const auto best = [&](std::size_t first) {
    return std::min(errors->network(kDecidingStep, first).median,
                    errors->network(kDecidingStep, first + 1).median);
  };
  const double small = best(1), large = best(3);
  order.ours = {{"lambda_1_percent", small}, {"lambda_100_percent", large}};
  order.stand_in(large_wins ? large < small : small < large);
  if (!*order.holds)
    order.remark +=
        large_wins ? "On these scans the higher weight flattens the lobes by more than it takes out of the "
                     "lengths' errors. "
                   : "On these scans smoothing takes out more noise than shape. ";
  run.add(std::move(order));

  const Spread made = errors->surface(kDecidingStep, 0);
  surface.ours = spread_json(made);
  if (is_seven) {
    const SetErrors* five = data.errors(run, kDevice);
    const double before = five->surface(kDecidingStep, 0).median;
    surface.ours["with_5_curves_percent"] = before;
    surface.remark +=
        before > made.median ? "Ours falls with more curves. " : "Ours does not fall with more curves. ";
    surface.stand_in(std::nullopt);
  } else {
    surface.stand_in(made.median <= 0.62);
  }
  add_error_table(
      surface, concat("Surface error, ", set.key),
      [&](std::size_t h, std::size_t w) { return errors->surface(h, w); },
      is_seven ? std::pair(1.0, std::string("S: about 1")) : std::pair(0.62, std::string("S: the smallest")));
  draw_seed(run, data, set, surface);
  run.add(std::move(surface));
}

/// S 3.14 and 4.19: the three ways of acquisition side by side.
void setups(ThesisRun& run, AcquiredData& data) {
  constexpr const DataSet* kSets[] = {&kDevice, &kMeasured, &kEstimated};
  constexpr const char* kNames[] = {"device", "phone_measured", "phone_estimated"};
  ThesisRow network =
      row_of(run, data, kDevice, "3.14",
             "Networks: about 1 % with measured lengths, by either device, and about 2 % with "
             "estimated ones.");
  network.thesis = {{"device_percent", 1}, {"phone_measured_percent", 1}, {"phone_estimated_percent", 2}};
  ThesisRow surface =
      row_of(run, data, kDevice, "4.19",
             "Surfaces: all mean errors are below 1 %, the smallest by phone with measured lengths.");
  surface.thesis = {{"all_below_percent", 1}, {"smallest", "phone, measured lengths"}};
  double networks[3] = {}, surfaces[3] = {};
  ReportGrid grid;
  grid.note =
      "Mean distance from the true surface in per cent of the diameter at h = 1.6 %: median / worst of the "
      "seeds.";
  grid.columns = {"set-up", "network, ours", "network, λ = 1, μ = 100", "surface, ours"};
  for (std::size_t k = 0; k < 3; ++k) {
    const SetErrors* errors = data.errors(run, *kSets[k]);
    if (errors == nullptr) {
      run.add(std::move(network));
      run.add(std::move(surface));
      return;
    }
    networks[k] = errors->network(kDecidingStep, 0).median;
    surfaces[k] = errors->surface(kDecidingStep, 0).median;
    network.ours[concat(kNames[k], "_percent")] = networks[k];
    surface.ours[concat(kNames[k], "_percent")] = surfaces[k];
    grid.rows.push_back({kSets[k]->key, spread_text(errors->network(kDecidingStep, 0)),
                         spread_text(errors->network(kDecidingStep, 2)),
                         spread_text(errors->surface(kDecidingStep, 0))});
  }
  network.data = surface.data = run.seeds_text("simulated scans of sections of lilium.obj");
  network.grids = {grid};
  network.stand_in(networks[0] <= 1 && networks[1] <= 1 && networks[2] <= 2 && networks[2] > networks[0] &&
                   networks[2] > networks[1]);
  surface.stand_in(*std::max_element(surfaces, surfaces + 3) < 1 && surfaces[1] <= surfaces[0] &&
                   surfaces[1] <= surfaces[2]);
  if (!*surface.holds && *std::max_element(surfaces, surfaces + 3) < 1)
    surface.remark =
        "All are below 1 %; the order depends on how even the hand and how good the odometer are, which S "
        "does "
        "not state.";
  run.add(std::move(network));
  run.add(std::move(surface));
}

}  // namespace

std::vector<ThesisExperiment> thesis_s_scans() {
  const auto data = std::make_shared<AcquiredData>();
  std::vector<ThesisExperiment> experiments;
  experiments.push_back({{"S 3.18", "S 5.17"}, [data](ThesisRun& run) { cone(run, *data); }});
  for (const DataSet* set : {&kEstimated, &kMeasured, &kDevice, &kSevenCurves})
    experiments.push_back({{concat("S ", set->figure), concat("S ", set->figure, " weights"),
                            concat("S ", set->surface_figure)},
                           [data, set](ThesisRun& run) { lilium(run, *data, *set); }});
  experiments.push_back({{"S 3.14", "S 4.19"}, [data](ThesisRun& run) { setups(run, *data); }});
  return experiments;
}

}  // namespace batten::experiments
