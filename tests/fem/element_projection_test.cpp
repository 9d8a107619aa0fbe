#include "sim/fem/element_projection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <gtest/gtest.h>

#include "sim/base/aligned.h"
#include "sim/base/types.h"
#include "sim/fem/inertia_shares.h"
#include "sim/fem/kernels/projection.h"
#include "tests/runnable_isas.h"

namespace wry::fem {
namespace {

/// One lane of a batch of element Hessians, as a matrix.
template <int D> struct Lane {
  static constexpr int SIZE = 4 * D;
  using Matrix = Eigen::Matrix<double, SIZE, SIZE>;
  static constexpr int NUMBER = 3;
  AlignedVector<double> storage = AlignedVector<double>(10 * D * D * LANES, 7.0);

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

/// Whether the lane was changed.
template <int D> bool project(Lane<D>& lane, const std::array<double, 4>& inertia, Isa isa) {
  if constexpr (D == 6) {
    return project_element(lane.storage.data(), Lane<D>::NUMBER, inertia);
  } else {
    alignas(64) double of_lanes[4][LANES];
    for (std::size_t k = 0; k < 4; ++k)
      std::fill(of_lanes[k], of_lanes[k] + LANES, inertia[k]);
    return find_projection(isa)(lane.storage.data(), Lane<D>::NUMBER + 1, of_lanes) > 0;
  }
}

template <int D> void check_projection(Isa isa) {
  using Matrix = typename Lane<D>::Matrix;
  Lane<D> lane;
  std::fill(lane.storage.begin(), lane.storage.end(), 0.0); // of the neighbours, too
  const Matrix original = indefinite_element<D>();
  lane.put(original);
  ASSERT_TRUE(project<D>(lane, {}, isa));
  const Matrix projected = lane.get();
  const Eigen::SelfAdjointEigenSolver<Matrix> alone(projected);
  EXPECT_NEAR(alone.eigenvalues().minCoeff(), 0.0, 1e-12);
  EXPECT_NEAR(alone.eigenvalues().maxCoeff(), 2.0, 1e-12);
  for (std::size_t i = 0; i < lane.storage.size(); ++i) {
    if (i % LANES != Lane<D>::NUMBER) {
      EXPECT_EQ(lane.storage[i], 0.0) << "a neighbour in the batch was touched";
    }
  }

  // With inertia: what is projected is the sum, so less of the matrix changes.
  const std::array<double, 4> even = {0.3, 0.3, 0.3, 0.3}, uneven = {0.3, 0.4, 0.5, 0.6};
  for (const std::array<double, 4>& inertia : {even, uneven}) {
    lane.put(original);
    ASSERT_TRUE(project<D>(lane, inertia, isa));
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
  for (const Isa isa : test::runnable_isas())
    check_projection<3>(isa);
  check_projection<6>(Isa::sse4);
}

TEST(ProjectElement, ClampsEachElementOfABatchAsEigenvaluesSay) {
  // Elements with none to nine negative eigenvalues of all sizes, pairs of them equal, one in each lane.
  using Matrix = Lane<3>::Matrix;
  const Eigen::Matrix<double, 12, 12> basis = [] {
    Eigen::Matrix<double, 12, 12> directions = Eigen::Matrix<double, 12, 12>::Identity();
    for (int node = 0; node < 4; ++node)
      directions.block<3, 3>(3 * node, 0) = Mat3::Identity();
    return Eigen::Matrix<double, 12, 12>(
        Eigen::HouseholderQR<Eigen::Matrix<double, 12, 12>>(directions).householderQ());
  }();
  std::mt19937 random(23);
  std::normal_distribution<double> normal;
  for (const Isa isa : test::runnable_isas()) {
    for (int round = 0; round < 40; ++round) {
      AlignedVector<double> storage(90 * LANES);
      std::vector<Matrix> before, wanted;
      alignas(64) double inertia[4][LANES];
      const double scale = std::pow(10.0, normal(random) * 3.0);
      int indefinite = 0;
      const int count = round % 3 == 0 ? 5 : LANES;
      for (int lane = 0; lane < LANES; ++lane) {
        Eigen::Matrix<double, 9, 9> turn;
        for (int i = 0; i < 81; ++i)
          turn(i / 9, i % 9) = normal(random);
        turn = Eigen::HouseholderQR<Eigen::Matrix<double, 9, 9>>(turn).householderQ();
        Eigen::Matrix<double, 9, 1> values, clamped;
        const double mass = round % 2 == 0 ? 0.0 : 0.1 * scale;
        for (int i = 0; i < 9; ++i)
          values[i] = scale * (std::abs(normal(random)) * (i < (lane + round) % 10 ? -1.0 : 1.0) + 1e-3);
        if (round % 5 == 0)
          values[1] = values[0];
        for (int i = 0; i < 9; ++i)
          clamped[i] = std::max(values[i], -mass);
        const Eigen::Matrix<double, 12, 9> rest = basis.rightCols<9>() * turn;
        before.push_back(rest * values.asDiagonal() * rest.transpose());
        wanted.push_back(rest * clamped.asDiagonal() * rest.transpose());
        indefinite += lane < count && (values.array() < -mass).any() ? 1 : 0;
        for (int k = 0; k < 4; ++k)
          inertia[k][lane] = mass;
        Lane<3>::for_each_entry([&](int entry, int row, int column) {
          storage[static_cast<std::size_t>(entry - Lane<3>::NUMBER + lane)] = before.back()(row, column);
        });
      }
      EXPECT_EQ(find_projection(isa)(storage.data(), count, inertia), indefinite);
      for (std::size_t lane = 0; lane < LANES; ++lane) {
        const Matrix& expected = static_cast<int>(lane) < count ? wanted[lane] : before[lane];
        Matrix found;
        Lane<3>::for_each_entry([&](int entry, int row, int column) {
          found(row, column) = found(column, row) = storage[static_cast<std::size_t>(entry - Lane<3>::NUMBER) + lane];
        });
        EXPECT_LT((found - expected).norm(), 1e-13 * scale * 9.0);
      }
    }
  }
}

TEST(ProjectElement, LeavesElementsAloneThatInertiaHolds) {
  Lane<3> lane;
  const Lane<3>::Matrix original = indefinite<Lane<3>::Matrix>();
  lane.put(original);
  for (const Isa isa : test::runnable_isas()) {
    EXPECT_FALSE(project<3>(lane, {1.1, 1.1, 1.1, 1.1}, isa));
    EXPECT_EQ(lane.get(), original);
  }
}

TEST(ProjectElement, ChangesOnlyRotationsWherePositionsAreDefinite) {
  Lane<6> lane;
  Lane<6>::Matrix original = indefinite<Lane<6>::Matrix>();
  for (int k = 0; k < 4; ++k)
    original.diagonal().segment<3>(6 * k).array() += 1.0;
  lane.put(original);
  const std::array<double, 4> inertia = {0.1, 0.2, 0.3, 0.4};
  ASSERT_TRUE(project_element(lane.storage.data(), Lane<6>::NUMBER, inertia));
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
