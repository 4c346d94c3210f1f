#pragma once
#include <string>
#include <vector>

#include <pybind11/pybind11.h>

namespace batten::python {

/// A sentence of the library or of a command as Python says it: `--keep-edges` and `keep_edges` in backquotes
/// become keep_edges.
std::string spoken(const std::string& sentence);
std::vector<std::string> spoken(std::vector<std::string> sentences);

/// Lets what the library throws arrive as the classes of batten._errors, with its sentence; memory that
/// cannot be had as MemoryError.
void add_errors(pybind11::module_& module);

}  // namespace batten::python
