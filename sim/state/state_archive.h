#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace wry {

/// One array of the simulation's state, float64, as a checkpoint stores it.
struct NamedArray {
  std::string name; ///< path with slashes, e.g. "fem/positions"
  std::vector<std::size_t> shape;
  std::vector<double> values; ///< row-major, product(shape) entries
};

/// All of a simulation's mutable state: restoring it continues bit for bit.
using StateArchive = std::vector<NamedArray>;

} // namespace wry
