#include "batten/session/playing.hpp"

#include "../sketch/strokes.hpp"
#include "one_model.hpp"

#include <gtest/gtest.h>

namespace batten {
namespace {

using namespace strokes;
using test::kModel;
using test::on_model;

/// The edits of a session of one model that is there.
Session session_of(const std::vector<SketchEdit>& edits) {
  Session session;
  for (const SketchEdit& edit : edits)
    session.edits.push_back({static_cast<long>(session.edits.size()) + 2, on_model(edit)});
  return session;
}

InsertEdit line(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return {{polygon({from, to}), false}, {}};
}

const InsertEdit kOutline{circle(kO, kX, kY), {}};
// A diameter, and a stroke from the outline to its middle.
const InsertEdit kAcross = line(-kX, kX), kHalf = line(kY, kO);

// A stroke that ends on one drawn later waits for it; edits that name its curve wait too, and names are those
// of the session: c1 is the stroke that waited, c2 the one that it waited for. The model is that of the right
// order.
TEST(PlaySession, WaitsForWhatAStrokeEndsOn) {
  Document late = test::one_model(), in_turn = test::one_model();
  const auto played = play_session(
      session_of({kOutline, kHalf, SharpnessEdit{1, 0.25, {}}, kAcross, SharpnessEdit{2, 0.5, {}}}), late);
  for (const PlayedEdit& entry : played) EXPECT_TRUE(entry.done) << entry.index;
  EXPECT_EQ(played[1].after, 3U);
  EXPECT_FALSE(played[1].reason.empty());
  EXPECT_EQ(played[2].after, 3U);
  EXPECT_EQ(played[3].after, 3U);
  EXPECT_TRUE(played[4].reason.empty());
  play_session(session_of({kOutline, kAcross, kHalf, SharpnessEdit{1, 0.5, {}}, SharpnessEdit{2, 0.25, {}}}),
               in_turn);
  EXPECT_EQ(late.model(kModel).counts().faces, 3);
  EXPECT_TRUE(late.model(kModel) == in_turn.model(kModel));
}

// What nothing helps is refused in the end, with what was said in its turn, and takes nothing else with it.
TEST(PlaySession, OneRefusedStrokeTakesNoOthers) {
  Document document = test::one_model();
  const auto played = play_session(
      session_of({kOutline, line(5 * kX, 6 * kX), kAcross, SharpnessEdit{1, 0.5, {}}}), document);
  EXPECT_FALSE(played[1].done);
  EXPECT_NE(played[1].reason.find("4 from the nearest curve, c0"), std::string::npos) << played[1].reason;
  EXPECT_TRUE(played[2].done);
  EXPECT_TRUE(played[3].done) << "names are taken as they stand at the end";
  EXPECT_EQ(document.model(kModel).edge(document.model(kModel).edges_of_curve(1).front()).sharpness, 0.5);
}

// The remedy of a refusal, a larger snapping distance, works when it is followed.
TEST(PlaySession, FollowingARemedyHelps) {
  Document document = test::one_model();
  InsertEdit far = line(-0.7 * kX, 0.7 * kX);
  const auto refused = play_session(session_of({kOutline, far}), document);
  ASSERT_FALSE(refused[1].done);
  const std::string word = "give a snap of ";
  const size_t at = refused[1].remedy.find(word);
  ASSERT_NE(at, std::string::npos) << refused[1].remedy;
  far.options.snap = std::stod(refused[1].remedy.substr(at + word.size()));
  EXPECT_TRUE(document.apply(on_model(far)).report.curves.size() == 1);
}

// Undo ends all waiting: what is undone must be what was done last.
TEST(PlaySession, NothingWaitsOverAnUndo) {
  Document document = test::one_model();
  Session session = session_of({kOutline, kHalf});
  session.edits.push_back({4, UndoEdit{}});
  session.edits.push_back({5, on_model(kOutline)});
  session.edits.push_back({6, on_model(kAcross)});
  const auto played = play_session(session, document);
  EXPECT_FALSE(played[1].done);
  EXPECT_TRUE(played[4].done);
  EXPECT_EQ(document.model(kModel).counts().curves, 2);
}

}  // namespace
}  // namespace batten
