#include "sim/fem/element_projection.h"

#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <gtest/gtest.h>

#include "sim/base/types.h"
#include "sim/fem/inertia_shares.h"

namespace wry::fem {
namespace {

/// One lane of a batch of element Hessians, as a matrix.
template <int D> struct Lane {
  static constexpr int SIZE = 4 * D;
  using Matrix = Eigen::Matrix<double, SIZE, SIZE>;
  static constexpr int NUMBER = 3;
  std::vector<double> storage = std::vector<double>(10 * D * D * LANES, 7.0);

  template <class Body> static void for_each_entry(const Body& body) {
    int block = 0;
    for (int k = 0; k < 4; ++k) {
      for (int l = k; l < 4; ++l, ++block) {
        for (int i = 0; i < D; ++i) {
          for (int j = 0; j < D; ++j)
            body(((block * D + i) * D + j) * LANES + NUMBER, k * D + i, l * D + j);
        }
      }
    }
  }
  void put(const Matrix& m) {
    for_each_entry([&](int entry, int row, int column) { storage[static_cast<std::size_t>(entry)] = m(row, column); });
  }
  Matrix get() const {
    Matrix m;
    for_each_entry([&](int entry, int row, int column) {
      m(row, column) = m(column, row) = storage[static_cast<std::size_t>(entry)];
    });
    return m;
  }
};

/// Eigenvalues -1 .. 2 in a basis without structure.
template <class Matrix> Matrix indefinite() {
  Matrix wave;
  for (int i = 0; i < wave.size(); ++i)
    wave.data()[i] = std::sin(1.0 + 0.7 * i + 0.01 * i * i);
  const Eigen::SelfAdjointEigenSolver<Matrix> basis(wave + wave.transpose());
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(wave.rows(), -1.0, 2.0);
  const Matrix m = basis.eigenvectors() * values.asDiagonal() * basis.eigenvectors().transpose();
  return 0.5 * (m + m.transpose());
}

/// The same for an element; with three unknowns per node it does not feel translations.
template <int D> typename Lane<D>::Matrix indefinite_element() {
  if constexpr (D == 6) {
    return indefinite<Lane<6>::Matrix>();
  } else {
    Eigen::Matrix<double, 12, 12> directions = Eigen::Matrix<double, 12, 12>::Identity();
    for (int node = 0; node < 4; ++node)
      directions.block<3, 3>(3 * node, 0) = Mat3::Identity(); // then the others, made orthogonal to them
    const Eigen::Matrix<double, 12, 12> basis =
        Eigen::HouseholderQR<Eigen::Matrix<double, 12, 12>>(directions).householderQ();
    return basis.rightCols<9>() * indefinite<Eigen::Matrix<double, 9, 9>>() * basis.rightCols<9>().transpose();
  }
}

template <int D> void check_projection() {
  using Matrix = typename Lane<D>::Matrix;
  Lane<D> lane;
  const Matrix original = indefinite_element<D>();
  lane.put(original);
  ASSERT_TRUE(project_element<D>(lane.storage.data(), Lane<D>::NUMBER, {}));
  const Matrix projected = lane.get();
  const Eigen::SelfAdjointEigenSolver<Matrix> alone(projected);
  EXPECT_NEAR(alone.eigenvalues().minCoeff(), 0.0, 1e-12);
  EXPECT_NEAR(alone.eigenvalues().maxCoeff(), 2.0, 1e-12);
  EXPECT_EQ(lane.storage[Lane<D>::NUMBER - 1], 7.0) << "a neighbour in the batch was touched";

  // With inertia: what is projected is the sum, so less of the matrix changes.
  const std::array<double, 4> even = {0.3, 0.3, 0.3, 0.3}, uneven = {0.3, 0.4, 0.5, 0.6};
  for (const std::array<double, 4>& inertia : {even, uneven}) {
    lane.put(original);
    ASSERT_TRUE(project_element<D>(lane.storage.data(), Lane<D>::NUMBER, inertia));
    Matrix sum = lane.get();
    EXPECT_LT((sum - original).norm(), (projected - original).norm());
    for (int k = 0; k < 4; ++k)
      sum.diagonal().template segment<3>(k * D).array() += inertia[static_cast<std::size_t>(k)];
    const double least = Eigen::SelfAdjointEigenSolver<Matrix>(sum).eigenvalues().minCoeff();
    EXPECT_GT(least, -1e-12);
    if (D == 6 || inertia == even) {
      EXPECT_NEAR(least, 0.0, 1e-12) << "more than is needed";
    }
  }
}

TEST(ProjectElement, MakesWhatIsLeftSemidefiniteAndNoMore) {
  check_projection<3>();
  check_projection<6>();
}

TEST(ProjectElement, LeavesElementsAloneThatInertiaHolds) {
  Lane<3> lane;
  const Lane<3>::Matrix original = indefinite<Lane<3>::Matrix>();
  lane.put(original);
  EXPECT_FALSE(project_element<3>(lane.storage.data(), Lane<3>::NUMBER, {1.1, 1.1, 1.1, 1.1}));
  EXPECT_EQ(lane.get(), original);
}

TEST(ProjectElement, ChangesOnlyRotationsWherePositionsAreDefinite) {
  Lane<6> lane;
  Lane<6>::Matrix original = indefinite<Lane<6>::Matrix>();
  for (int k = 0; k < 4; ++k)
    original.diagonal().segment<3>(6 * k).array() += 1.0;
  lane.put(original);
  const std::array<double, 4> inertia = {0.1, 0.2, 0.3, 0.4};
  ASSERT_TRUE(project_element<6>(lane.storage.data(), Lane<6>::NUMBER, inertia));
  const Lane<6>::Matrix projected = lane.get();
  for (int row = 0; row < 24; ++row) {
    for (int column = 0; column < 24; ++column) {
      if (row % 6 < 3 || column % 6 < 3) {
        EXPECT_EQ(projected(row, column), original(row, column));
      }
    }
  }
  Lane<6>::Matrix sum = projected;
  for (int k = 0; k < 4; ++k)
    sum.diagonal().segment<3>(k * 6).array() += inertia[static_cast<std::size_t>(k)];
  EXPECT_NEAR(Eigen::SelfAdjointEigenSolver<Lane<6>::Matrix>(sum).eigenvalues().minCoeff(), 0.0, 1e-12);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Lane<6>::Matrix>(projected - original).eigenvalues().minCoeff(), -1e-12)
      << "it may only get stiffer";
}

TEST(InertiaShares, AddUpToHalfTheMass) {
  InertiaShares shares;
  shares.add_corner(0, 2.0);
  shares.add_corner(1, 2.0);
  shares.add_corner(1, 3.0);
  shares.finish({0.5, 4.0});
  Stage stage;
  stage.beta = 0.1;
  const auto of = [&](int node, double volume) {
    return shares.at(node, volume, stage, Projection::elements_with_inertia);
  };
  EXPECT_NEAR(of(0, 2.0), 0.5 * 0.5 / 0.01, 1e-12);
  EXPECT_NEAR(of(1, 2.0) + of(1, 3.0), 0.5 * 4.0 / 0.01, 1e-12);
  EXPECT_EQ(shares.at(1, 2.0, stage, Projection::elements), 0.0);
}

} // namespace
} // namespace wry::fem
