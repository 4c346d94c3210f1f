#include "batten/core/error.hpp"

#include <string>

#include <gtest/gtest.h>

namespace batten {
namespace {

TEST(FileError, NamesTheFileAndTheLineWhereThereIsOne) {
  const FileError with_line("a.obj", 12, "a face names no vertex"), without("a.obj", 0, "is missing");
  EXPECT_EQ(std::string(with_line.what()), "a.obj:12: a face names no vertex");
  EXPECT_EQ(with_line.path(), "a.obj");
  EXPECT_EQ(with_line.line(), 12);
  EXPECT_EQ(std::string(without.what()), "a.obj: is missing");
}

TEST(SolverFailure, NamesTheSystemAndItsSize) {
  EXPECT_NE(std::string(SolverFailure("thin plate", 42).what()).find("thin plate (42 unknowns)"),
            std::string::npos);
}

// Front ends tell them apart by type: input to mend, work that failed, work that was stopped.
TEST(Errors, AreToldApartByTheirCause) {
  EXPECT_THROW(throw FileError("a", 0, "b"), InvalidInput);
  EXPECT_THROW(throw SolverFailure("a", 1), Error);
  EXPECT_THROW(throw Cancelled(), Error);
  const SolverFailure failure("a", 1);
  const Cancelled cancelled;
  EXPECT_EQ(dynamic_cast<const InvalidInput*>(static_cast<const Error*>(&failure)), nullptr);
  EXPECT_EQ(dynamic_cast<const InvalidInput*>(static_cast<const Error*>(&cancelled)), nullptr);
}

}  // namespace
}  // namespace batten
