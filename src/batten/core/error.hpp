#pragma once
#include <stdexcept>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace batten {

/// Base of everything batten throws. what() is one sentence a user can act on.
class Error : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// An argument or a file breaks a documented precondition; the caller can repair it.
class InvalidInput : public Error {
  using Error::Error;
};

/// A file cannot be read or written. The sentence names the file and, where there is one, the line.
class FileError : public InvalidInput {
 public:
  /// @param line 1-based; 0 where no line is to blame (missing file, binary file).
  FileError(std::string_view path, long line, std::string_view problem);
  const std::string& path() const { return path_; }
  long line() const { return line_; }

 private:
  std::string path_;
  long line_;
};

/// A linear system could not be factorised or solved; `system` says which one.
class SolverFailure : public Error {
 public:
  /// @param system what the equations are for, as in "mean curvature flow". @param unknowns how many there
  /// are.
  SolverFailure(std::string_view system, Eigen::Index unknowns);
};

/// The caller asked for the work to stop (see Progress). Nothing has been changed.
class Cancelled : public Error {
 public:
  Cancelled();
};

}  // namespace batten
