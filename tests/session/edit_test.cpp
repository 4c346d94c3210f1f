#include "batten/session/edit.hpp"

#include <gtest/gtest.h>

namespace batten {
namespace {

TEST(Edit, EveryOneHasAName) {
  const std::vector<std::pair<Edit, std::string>> names{{AddEdit{}, "add"},
                                                        {DeriveEdit{}, "derive"},
                                                        {RemoveEdit{}, "remove"},
                                                        {RenameEdit{}, "rename"},
                                                        {UnitEdit{}, "unit"},
                                                        {ReplaceEdit{}, "replace"},
                                                        {ScanCurveEdit{}, "curve"},
                                                        {RequestEdit{}, "request"},
                                                        {ViewEdit{}, "view"},
                                                        {UndoEdit{}, "undo"},
                                                        {RedoEdit{}, "redo"},
                                                        {CheckpointEdit{}, "checkpoint"},
                                                        {ModelEdit{{1}, InsertEdit{}, 0}, "insert"},
                                                        {ModelEdit{{1}, TransformEdit{}, 0}, "transform"}};
  for (const auto& [edit, name] : names) EXPECT_EQ(name_of_op(edit), name);
}

TEST(Edit, DragsAreOfOneNumberOneObjectAndOneThing) {
  const Edit fair = RequestEdit{{2}, FairRequest{}, 4};
  EXPECT_TRUE(within_one_drag(fair, RequestEdit{{2}, FairRequest{}, 4}));
  EXPECT_FALSE(within_one_drag(fair, RequestEdit{{2}, FairRequest{}, 5}));
  EXPECT_FALSE(within_one_drag(fair, RequestEdit{{3}, FairRequest{}, 4}));
  EXPECT_FALSE(within_one_drag(fair, RequestEdit{{2}, RemeshRequest{}, 4}));
  EXPECT_FALSE(within_one_drag(RequestEdit{{2}, FairRequest{}, 0}, RequestEdit{{2}, FairRequest{}, 0}));
  EXPECT_FALSE(within_one_drag(fair, ViewEdit{{2}, {}, 4}));
  EXPECT_TRUE(within_one_drag(ViewEdit{{2}, {}, 4}, ViewEdit{{2}, {}, 4}));
  EXPECT_FALSE(within_one_drag(fair, UndoEdit{}));
  EXPECT_TRUE(within_one_drag(ScanCurveEdit{{2}, 1, nullptr, 4}, ScanCurveEdit{{2}, 1, nullptr, 4}));
  EXPECT_FALSE(within_one_drag(ScanCurveEdit{{2}, 1, nullptr, 4}, ScanCurveEdit{{2}, 0, nullptr, 4}));
}

}  // namespace
}  // namespace batten
