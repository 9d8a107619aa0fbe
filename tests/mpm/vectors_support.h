#pragma once

#include <nlohmann/json.hpp>

#include "sim/mpm/matter/matter.h"

/// Reading the vectors of the anisotropic material point method.
namespace wry::mpm::test {

Vec3 vec3(const nlohmann::json& list);
Mat3 mat3(const nlohmann::json& rows);
Eigen::MatrixXd matrix(const nlohmann::json& rows);

OrthotropicElasticity elasticity_of(const nlohmann::json& ortho);

/// A^sigma from `a` or `A_sigma_mandel`.
Mat6 stress_map_of(const nlohmann::json& input);

/// The matter of a `stress`, `project` or `mpm10` vector.
Matter matter_of(const nlohmann::json& input);

/// max |actual - expected| <= tolerance max(1e-300, max |expected|), as the vectors ask.
void expect_close(const Eigen::MatrixXd& actual, const Eigen::MatrixXd& expected, double tolerance,
                  const std::string& what);

} // namespace wry::mpm::test
