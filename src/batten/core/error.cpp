#include "batten/core/error.hpp"

#include "batten/core/text.hpp"

namespace batten {

namespace {

std::string file_sentence(std::string_view path, long line, std::string_view problem) {
  if (line > 0) return concat(path, ":", line, ": ", problem);
  return concat(path, ": ", problem);
}

}  // namespace

FileError::FileError(std::string_view path, long line, std::string_view problem)
    : InvalidInput(file_sentence(path, line, problem)), path_(path), line_(line) {}

SolverFailure::SolverFailure(std::string_view system, Eigen::Index unknowns)
    : Error(concat("the linear system of the ", system, " (", unknowns,
                   " unknowns) could not be solved: its matrix is singular or not finite")) {}

Cancelled::Cancelled() : Error("the work was cancelled") {}

}  // namespace batten
