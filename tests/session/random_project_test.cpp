#include "random_project.hpp"

#include "sanitizers.hpp"
#include "scratch.hpp"

#include <map>

#include <gtest/gtest.h>
#include <malloc.h>

#include "batten/session/edit_json.hpp"
#include "batten/session/journal.hpp"
#include "batten/session/project.hpp"

// What holds for any edits of a project, on edits of every kind without a plan.
namespace batten {
namespace {

using namespace test;

constexpr std::uint64_t kSeeds = test::repeated(5, 1);
constexpr int kEdits = 500;

/// All that a document holds, as text that tells every bit of it, without what led to it.
std::string text_of(const Document& document) {
  std::map<ObjectId, Object> objects;
  std::map<ObjectId, SharedModel> models;
  for (const ObjectId id : document.objects()) {
    objects[id] = document.object(id);
    if (document.object(id).kind() == ObjectKind::Model)
      models[id] = std::make_shared<const PolylineMesh>(document.model(id));
  }
  return format_session(Document::restored(objects, models).log());
}

std::map<ObjectId, std::uint64_t> versions_of(const Document& document) {
  std::map<ObjectId, std::uint64_t> versions;
  for (const ObjectId id : document.objects()) versions[id] = document.version(id);
  return versions;
}

struct State {
  std::string text;
  std::map<ObjectId, std::uint64_t> versions;
};

void expect_same(const Document& document, const State& state, const std::string& where) {
  EXPECT_EQ(text_of(document), state.text) << where;
  EXPECT_EQ(versions_of(document), state.versions) << where;
}

/// Makes edits until so many are done, with every state that undo may lead to held against what was there.
class EditingRun {
 public:
  explicit EditingRun(std::uint64_t seed) : project_(seed) { states_.push_back(state()); }

  void edit() {
    const Edit edit = project_.edit(document_);
    const State before = states_[at_];
    EditOutcome outcome;
    try {
      outcome = document_.apply(edit);
    } catch (const RefusedEdit&) {
      ++n_refused;
      expect_same(document_, before, "refused " + name_of_op(edit));
      return;
    }
    ++n_done[outcome.merged ? "merged" : name_of_op(edit)];
    if (std::holds_alternative<UndoEdit>(edit)) {
      expect_same(document_, states_[--at_], "undo");
    } else if (std::holds_alternative<RedoEdit>(edit)) {
      expect_same(document_, states_[++at_], "redo");
    } else {
      if (!outcome.merged) ++at_;
      states_.resize(at_);
      states_.push_back(state());
    }
    expect_versions_follow(before, outcome);
  }

  void undo_and_redo_everything() {
    while (document_.can_redo()) document_.apply(RedoEdit{});
    ASSERT_FALSE(document_.can_redo());
    const std::size_t last = states_.size() - 1;
    for (at_ = last; document_.can_undo();) {
      document_.apply(UndoEdit{});
      expect_same(document_, states_[--at_], "undo of everything");
    }
    EXPECT_EQ(at_, 0u);
    while (document_.can_redo()) {
      document_.apply(RedoEdit{});
      expect_same(document_, states_[++at_], "redo of everything");
    }
    EXPECT_EQ(at_, last);
  }

  Document& document() { return document_; }
  std::map<std::string, int> n_done;
  int n_refused = 0;

 private:
  State state() const { return {text_of(document_), versions_of(document_)}; }

  /// Results are out of date exactly where their numbers have changed, and what is not said to be changed is
  /// what it was.
  void expect_versions_follow(const State& before, const EditOutcome& outcome) {
    std::vector<ObjectId> outdated;
    for (const ObjectId id : document_.out_of_date(before.versions)) outdated.push_back(id);
    EXPECT_EQ(outcome.outdated, outdated);
    for (const ObjectId id : outcome.outdated) {
      const Derived* derived = document_.object(id).derived();
      ASSERT_NE(derived, nullptr);
      EXPECT_LT(derived->source, id);
    }
  }

  RandomProject project_;
  Document document_;
  std::vector<State> states_;
  std::size_t at_ = 0;
};

// Every edit is undone and redone bit for bit, wherever it stands; replayed from its journal, the document is
// the same to the bit; so it is from a project file.
TEST(RandomProject, FiveHundredEditsOfAllKindsAreUndoneAndRedoneBitForBit) {
  std::map<std::string, int> n_done;
  for (std::uint64_t seed = 1; seed <= kSeeds && !HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    EditingRun run(seed);
    while (run.document().log().size() < kEdits && !HasFailure()) run.edit();
    run.undo_and_redo_everything();
    for (const auto& [op, n] : run.n_done) n_done[op] += n;

    const Session session = parse_session(format_session(run.document().log()), "journal");
    Document played;
    for (const SessionEdit& edit : session.edits) played.apply(edit.edit);
    EXPECT_TRUE(played == run.document());
    EXPECT_EQ(text_of(played), text_of(run.document()));
    EXPECT_EQ(format_session(played.log()), format_session(run.document().log()));

    const std::string bytes = format_project(run.document());
    const ProjectFile read = parse_project(bytes, "random.batten");
    EXPECT_TRUE(read.warnings.empty());
    EXPECT_EQ(text_of(read.document), text_of(run.document()));
    EXPECT_EQ(format_project(read.document), bytes);
  }
  // The test is worth something only where every kind of edit is done now and then; one seed may miss a kind.
  if (kSeeds == 1) return;
  for (const char* op : {"add", "derive", "remove", "rename", "unit", "replace", "curve", "request", "view",
                         "insert", "delete", "sharpness", "undo", "redo", "merged"})
    EXPECT_GT(n_done[op], 0) << op;
}

// A mesh of 100,000 faces, and 500 edits that bring no data: none of them keeps a copy of anything large, and
// what lists of vertices they bring they share. The bound is one more copy of the mesh.
TEST(RandomProject, MemoryOfEditsOnALargeMeshIsBounded) {
#if defined(BATTEN_SANITIZED) || !defined(__GLIBC__)
  GTEST_SKIP() << "sanitizers keep their own account of memory";
#else
  constexpr int kSide = 224;  // 2 · 223² faces
  TriangleMesh mesh;
  mesh.positions.resize(kSide * kSide, 3);
  for (int i = 0; i < kSide * kSide; ++i) mesh.positions.row(i) << i % kSide, i / kSide, 0;
  mesh.triangles.resize(2 * (kSide - 1) * (kSide - 1), 3);
  for (int y = 0, t = 0; y + 1 < kSide; ++y)
    for (int x = 0; x + 1 < kSide; ++x) {
      const int v = y * kSide + x;
      mesh.triangles.row(t++) << v, v + 1, v + kSide + 1;
      mesh.triangles.row(t++) << v, v + kSide + 1, v + kSide;
    }
  ASSERT_NEAR(static_cast<double>(mesh.n_triangles()), 1e5, 1e3);
  const std::size_t size = static_cast<std::size_t>(mesh.positions.size()) * sizeof(double) +
                           static_cast<std::size_t>(mesh.triangles.size()) * sizeof(int);
  std::vector<int> half(static_cast<std::size_t>(kSide * kSide / 2));
  for (std::size_t i = 0; i < half.size(); ++i) half[i] = static_cast<int>(i);

  Document document;
  const ObjectId given =
      document.apply(AddEdit{{}, "scan", "mm", std::make_shared<const TriangleMesh>(mesh)}).object;
  const ObjectId faired = document.apply(DeriveEdit{{}, "fair", given, FairRequest{}}).object;
  DeformRequest bend;
  bend.fixed = std::make_shared<const std::vector<int> >(half);
  const ObjectId bent = document.apply(DeriveEdit{{}, "bent", faired, bend}).object;
  const ObjectId view = document.apply(AddEdit{{}, "view", "", ViewState{}}).object;
  const std::size_t before = mallinfo2().uordblks;
  for (int k = 0; k < kEdits; ++k) {
    FairRequest fair;
    fair.options.noise = k;
    ViewState turned;
    turned.azimuth = k;
    bend.fixed = std::make_shared<const std::vector<int> >(half);  // as a reader of files gives it
    bend.moved.resize(1);
    bend.moved[0].vertices = std::make_shared<const std::vector<int> >(std::vector<int>{kSide * kSide - 1});
    bend.moved[0].translation = {0, 0, k + 1.0};
    const Edit edits[] = {RequestEdit{faired, fair, 0}, RenameEdit{given, "scan " + std::to_string(k)},
                          UnitEdit{given, k % 2 == 0 ? "m" : "mm"}, ViewEdit{view, turned, 0},
                          RequestEdit{bent, bend, 0}};
    document.apply(edits[k % 5]);
  }
  bend.fixed.reset();
  const std::size_t after = mallinfo2().uordblks;
  EXPECT_LT(after - before, size) << "mesh of " << size << " bytes";
  RecordProperty("bytes_per_edit", static_cast<int>((after - before) / kEdits));
  // The mesh is the one object that there was.
  const auto& held = std::get<SharedMesh>(*document.object(given).content());
  while (document.can_undo()) document.apply(UndoEdit{});
  document.apply(RedoEdit{});
  EXPECT_EQ(std::get<SharedMesh>(*document.object(given).content()), held);
#endif
}

// A scan of one curve of 200,000 readings and one of 20: edits of the small one keep 20 readings each,
// however large the other is. The bound is a hundredth of a copy of the scan for each edit.
TEST(RandomProject, MemoryOfEditsOfACurveIsThatOfTheCurve) {
#if defined(BATTEN_SANITIZED) || !defined(__GLIBC__)
  GTEST_SKIP() << "sanitizers keep their own account of memory";
#else
  const auto curve_of = [](Eigen::Index n, double value) {
    ScanCurve curve;
    curve.distances = Eigen::VectorXd::LinSpaced(n, 0, 1);
    curve.tangents = curve.normals = Points::Constant(n, 3, value);
    return curve;
  };
  Scan scan;
  scan.curves = {curve_of(200000, 0), curve_of(20, 0)};
  constexpr std::size_t kSize = 200000 * 7 * sizeof(double);
  Document document;
  const ObjectId id = document.apply(AddEdit{{}, "scan", "m", std::make_shared<const Scan>(scan)}).object;
  const auto held = [&]() -> const Scan& { return *std::get<SharedScan>(*document.object(id).content()); };
  const auto set_curve = [&](double value) {
    document.apply(ScanCurveEdit{id, 1, std::make_shared<const ScanCurve>(curve_of(20, value)), 0});
  };
  set_curve(1);  // the scan that was given is not changed but copied, once
  const double* large = held().curves[0].distances.data();
  const std::size_t before = mallinfo2().uordblks;
  constexpr int kEditsOfACurve = 100;
  for (int k = 2; k <= kEditsOfACurve; ++k) set_curve(k);
  EXPECT_LT(mallinfo2().uordblks - before, kEditsOfACurve * kSize / 100);
  for (int k = 0; k < 50; ++k) document.apply(UndoEdit{});
  EXPECT_EQ(held().curves[1].normals(0, 0), 50);
  for (int k = 0; k < 25; ++k) document.apply(RedoEdit{});
  EXPECT_EQ(held().curves[1].normals(0, 0), 75);
  EXPECT_EQ(held().curves[0].distances.data(), large) << "the whole scan was copied";
  RecordProperty("bytes_per_edit", static_cast<int>((mallinfo2().uordblks - before) / kEditsOfACurve));
#endif
}

// What someone else holds stays as it is, and is copied once.
TEST(RandomProject, ScansThatAreHeldDoNotChangeUnderTheirHolders) {
  ScanCurve curve;
  curve.distances = Eigen::VectorXd::Zero(2);
  curve.tangents = curve.normals = Points::Zero(2, 3);
  Scan scan;
  scan.curves = {curve, curve};
  Document document;
  const ObjectId id = document.apply(AddEdit{{}, "scan", "m", std::make_shared<const Scan>(scan)}).object;
  const auto content = [&] { return std::get<SharedScan>(*document.object(id).content()); };
  std::vector<SharedScan> held{content()};
  for (int k = 1; k <= 3; ++k) {
    curve.distances.setConstant(k);
    document.apply(ScanCurveEdit{id, 1, std::make_shared<const ScanCurve>(curve), 0});
    held.push_back(content());
  }
  const std::shared_ptr<const Object> object = document.shared(id);
  const Document copy = document;
  document.apply(UndoEdit{});
  document.apply(UndoEdit{});
  EXPECT_EQ(content()->curves[1].distances[0], 1);
  EXPECT_EQ(std::get<SharedScan>(*object->content())->curves[1].distances[0], 3);
  EXPECT_EQ(std::get<SharedScan>(*copy.object(id).content())->curves[1].distances[0], 3);
  for (int k = 0; k <= 3; ++k) EXPECT_EQ(held[static_cast<std::size_t>(k)]->curves[1].distances[0], k);
}

}  // namespace
}  // namespace batten
