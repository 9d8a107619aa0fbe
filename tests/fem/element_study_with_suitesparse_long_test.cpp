#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/utsname.h>

#include "sim/fem/element_kernels.h"
#include "sim/fem/mixed_group.h"
#include "sim/geometry/sheet_triangles.h"
#include "tests/fem/element_studies_support.h"
#include "tests/fem/solid_support.h"

/// The ladders behind docs/elements.md. With WRY_EVIDENCE naming a folder, each writes its table there as CSV.
namespace wry::fem {
namespace {

using namespace test;

class Table {
public:
  Table(const char* name, const char* columns) {
    utsname machine{};
    uname(&machine);
    if (const char* folder = std::getenv("WRY_EVIDENCE"); folder != nullptr && *folder != '\0') {
      m_file.open(std::string(folder) + "/" + name + ".csv");
      m_file << "# " << machine.machine << ", one thread, CPU time\n" << columns << "\n";
    }
    std::printf("%s\n%s\n", name, columns);
  }
  template <class... Values> void row(fmt::format_string<Values...> form, Values&&... values) {
    const std::string text = fmt::format(form, std::forward<Values>(values)...);
    std::printf("%s\n", text.c_str());
    if (m_file.is_open())
      m_file << text << "\n";
  }

private:
  std::ofstream m_file;
};

TEST(ElementStudy, ErrorAgainstRunTimeInBending) {
  Table table("elements_bending", "element,cells,unknowns,newton_iterations,cpu_s,deflection_ratio");
  struct Rung {
    const char* name;
    ElasticModel model;
    ElementKind element;
    int cells;
  };
  // The closed form knows nothing of how a clamp holds a section: the finest quadratic tets stand for the limit.
  const double limit = bend_bar(ElasticModel::micropolar, ElementKind::tet10, 4, 1.0).ratio;
  double best_linear = 1.0, coarsest_quadratic = 1.0, linear_seconds = 0.0, quadratic_seconds = 0.0;
  for (const Rung& rung : {Rung{"tet4", ElasticModel::micropolar, ElementKind::tet4, 1},
                           Rung{"tet4", ElasticModel::micropolar, ElementKind::tet4, 2},
                           Rung{"tet4", ElasticModel::micropolar, ElementKind::tet4, 3},
                           Rung{"tet4", ElasticModel::micropolar, ElementKind::tet4, 4},
                           Rung{"tet4", ElasticModel::micropolar, ElementKind::tet4, 6},
                           Rung{"tet4", ElasticModel::micropolar, ElementKind::tet4, 8},
                           Rung{"condensed", ElasticModel::corotated, ElementKind::tet4, 1},
                           Rung{"condensed", ElasticModel::corotated, ElementKind::tet4, 2},
                           Rung{"condensed", ElasticModel::corotated, ElementKind::tet4, 4},
                           Rung{"condensed", ElasticModel::corotated, ElementKind::tet4, 6},
                           Rung{"condensed", ElasticModel::corotated, ElementKind::tet4, 8},
                           Rung{"tet10", ElasticModel::micropolar, ElementKind::tet10, 1},
                           Rung{"tet10", ElasticModel::micropolar, ElementKind::tet10, 2},
                           Rung{"tet10", ElasticModel::micropolar, ElementKind::tet10, 3}}) {
    const Bending result = bend_bar(rung.model, rung.element, rung.cells, 1.0);
    table.row("{},{},{},{},{:.4f},{:.6f}", rung.name, rung.cells, result.unknowns, result.iterations,
              result.cpu_seconds, result.ratio / limit);
    const double error = std::abs(result.ratio / limit - 1.0);
    if (rung.element == ElementKind::tet10 && rung.cells == 1) {
      coarsest_quadratic = error;
      quadratic_seconds = result.cpu_seconds;
    }
    if (rung.element == ElementKind::tet4 && error < best_linear) {
      best_linear = error;
      linear_seconds = result.cpu_seconds;
    }
  }
  // One quadratic tet across the bar beats eight linear ones, in a fraction of their time.
  EXPECT_LT(coarsest_quadratic, best_linear);
  EXPECT_LT(quadratic_seconds, 0.2 * linear_seconds);
}

TEST(ElementStudy, LockingOfPlates) {
  Table table("elements_plate_locking", "element,thickness,cells,unknowns,cpu_s,deflection_ratio");
  for (const double thickness : {0.1, 0.03, 0.01, 0.003, 0.001}) {
    for (const int cells : {4, 8, 16, 32}) {
      for (const ElementKind element : {ElementKind::plate3, ElementKind::plate6}) {
        const Bending result = bend_plate(element, cells, thickness);
        table.row("{},{},{},{},{:.4f},{:.6f}", element == ElementKind::plate3 ? "tri3" : "tri6", thickness, cells,
                  result.unknowns, result.cpu_seconds, result.ratio);
        if (element == ElementKind::plate6) {
          EXPECT_NEAR(result.ratio, 1.0, 0.03) << thickness << " " << cells;
        }
      }
    }
  }
}

TEST(ElementStudy, ALargeCoupleModulusLocksLinearTets) {
  Table table("elements_couple_modulus", "element,cells,couple_modulus_ratio,deflection_ratio");
  for (const double ratio : {0.5, 1.0, 3.0, 10.0, 30.0, 100.0, 1000.0}) {
    const auto row = [&](const char* name, ElementKind element, int cells) {
      const double deflection = bend_bar(ElasticModel::micropolar, element, cells, ratio).ratio;
      table.row("{},{},{},{:.6f}", name, cells, ratio, deflection);
      return deflection;
    };
    row("tet4", ElementKind::tet4, 2);
    const double linear = row("tet4", ElementKind::tet4, 4);
    row("tet10", ElementKind::tet10, 1);
    const double quadratic = row("tet10", ElementKind::tet10, 2);
    if (ratio >= 100.0) {
      EXPECT_LT(linear, 0.3);
      EXPECT_GT(quadratic, 0.9);
    }
  }
}

TEST(ElementStudy, SizeEffectOfPlates) {
  Table table("elements_plate_size_effect", "element,cells,length_scale_over_thickness,ratio,closed_form");
  for (const double length_scale : {0.1, 0.2, 0.5, 1.0}) {
    const double exact = 1.0 + 3.0 * 0.7 * 2.0 * length_scale * length_scale;
    for (const int cells : {2, 4, 6, 8})
      table.row("tet4,{},{},{:.6f},{:.6f}", cells, length_scale,
                plate_stiffness_ratio(ElementKind::tet4, cells, 0.3, length_scale), exact);
    for (const int cells : {1, 2, 3, 4}) {
      const double ratio = plate_stiffness_ratio(ElementKind::tet10, cells, 0.3, length_scale);
      table.row("tet10,{},{},{:.6f},{:.6f}", cells, length_scale, ratio, exact);
      if (cells > 1) {
        EXPECT_NEAR(ratio / exact, 1.0, 0.02);
      }
    }
  }
}

/// Microseconds of CPU per element of a batch function, on elements that are in the cache.
template <class Run> double microseconds(int elements, const Run& run) {
  int rounds = 1;
  for (;; rounds *= 2) {
    const std::clock_t start = std::clock();
    for (int i = 0; i < rounds; ++i)
      run();
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    if (seconds > 0.2)
      return 1e6 * seconds / rounds / elements;
  }
}

TEST(ElementStudy, CostOfAnElement) {
  Table table("elements_kernels", "element,curvature,energy_us,gradient_us,hessian_us");
  const std::shared_ptr<const geometry::TetMesh> box = box_mesh(Vec3::Zero(), Vec3(1, 1, 1), 4, 4, 4);
  const geometry::SheetTriangles sheet =
      *geometry::make_sheet_triangles(1.0, 1.0, 14, 14, geometry::SheetSplit::alternating);
  double tet4 = 0.0, tet10 = 0.0;
  for (const bool curved : {false, true}) {
    FemBody body = make_body(box, ElasticModel::micropolar, 1.0, 0.3);
    body.material.length_scale = curved ? 0.1 : 0.0;
    body.material.curvature = curved ? CurvatureModel::isotropic : CurvatureModel::none;
    body.material.plate_bending = PlateBending::curv;
    body.thickness = 0.01;
    const auto fields_of = [](const Points& vertices, std::vector<double>(&fields)[3]) {
      fields[0].assign(vertices.data(), vertices.data() + vertices.size());
      fields[1].assign(static_cast<std::size_t>(vertices.size()), 0.01);
      fields[2].clear();
      for (Eigen::Index i = 0; i < vertices.rows(); ++i)
        fields[2].insert(fields[2].end(), {1.0, 0.0, 0.0, 0.0});
      return NodeFields{fields[0].data(), fields[1].data(), fields[2].data()};
    };
    std::vector<double> storage[3];
    const ElementGroup group = *build_element_group(*box, body.material, 0);
    const ElementKernel kernel = select_kernel(group, native_isa());
    const NodeFields fields = fields_of(box->vertices, storage);
    const std::unique_ptr<BatchDerivatives> out = std::make_unique<BatchDerivatives>();
    const auto all = [&](const auto& function) {
      return microseconds(group.element_count, [&] {
        for (int batch = 0; batch < group.batch_count; ++batch)
          function(batch);
      });
    };
    tet4 = all([&](int batch) { kernel.hessian(group, fields, batch, *out); });
    table.row("tet4,{},{:.4f},{:.4f},{:.4f}", curved,
              all([&](int batch) { kernel.energy(group, fields, batch, out->energy); }),
              all([&](int batch) { kernel.gradient(group, fields, batch, *out); }), tet4);
    for (const ElementKind kind :
         {ElementKind::tet4_one_point, ElementKind::tet10, ElementKind::plate3, ElementKind::plate6}) {
      FemBody mixed = body;
      if (is_plate(kind)) {
        mixed.mesh = std::make_shared<geometry::TetMesh>(sheet.mesh);
        mixed.triangles = sheet.triangles;
        mixed.element = ElementKind::plate3;
      }
      if (is_quadratic(kind))
        mixed = with_midpoints(std::move(mixed));
      else
        mixed.element = kind;
      const MixedGroup elements =
          *build_mixed_group(mixed, element_vertices(mixed), mixed.mesh->vertices, 0, native_isa());
      const NodeFields at = fields_of(mixed.mesh->vertices, storage);
      const std::unique_ptr<MixedDerivatives> to = std::make_unique<MixedDerivatives>();
      const auto time = [&](EvaluateMixed function) {
        return microseconds(elements.element_count, [&] {
          for (int batch = 0; batch < elements.batch_count; ++batch)
            function(elements.batch(batch), at, *to);
        });
      };
      constexpr const char* NAMES[] = {"tet4", "tet4 one point", "tet10", "tri3", "tri6"};
      const double hessian = time(elements.kernel->hessian);
      table.row("{},{},{:.4f},{:.4f},{:.4f}", NAMES[static_cast<int>(kind)], curved, time(elements.kernel->energy),
                time(elements.kernel->gradient), hessian);
      if (kind == ElementKind::tet10)
        tet10 = hessian;
    }
  }
  EXPECT_LT(tet10, 12.0 * tet4);
}

TEST(ElementStudy, RotationsDriftWithOnePoint) {
  Table table("elements_hourglass", "time_s,one_point_roughness_rad,four_points_roughness_rad");
  double one_point = 0.0, four_points = 0.0;
  for (const double time : {0.1, 0.2, 0.5, 1.0, 2.0, 4.0}) {
    one_point = spin_roughness(ElementKind::tet4_one_point, time);
    four_points = spin_roughness(ElementKind::tet4, time);
    table.row("{},{:.6f},{:.6f}", time, one_point, four_points);
  }
  EXPECT_GT(one_point, 20.0 * four_points);
}

TEST(ElementStudy, NeoHookeanMicrorotationsLetGoUnderTwist) {
  Table table("elements_twist", "model,turns,mean_distance_deg,energy");
  bool let_go = false;
  for (const ElasticModel model : {ElasticModel::micropolar, ElasticModel::micropolar_neo_hookean}) {
    const bool neo_hookean = model == ElasticModel::micropolar_neo_hookean;
    const std::vector<Twist> rows = twist_bar(model, 0.3, 1.5);
    ASSERT_EQ(rows.size(), 12u);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      table.row("{},{:.3f},{:.4f},{:.6f}", neo_hookean ? "micropolar-neo-hookean" : "micropolar", rows[i].turns,
                rows[i].mean_distance_deg, rows[i].energy);
      // Microrotations leave the matter, and the twist is no longer resisted.
      let_go = let_go || (neo_hookean && i > 0 && rows[i].mean_distance_deg > 1.5 * rows[i - 1].mean_distance_deg &&
                          rows[i].energy < 0.7 * rows[i - 1].energy);
    }
  }
  EXPECT_TRUE(let_go);
}

TEST(ElementStudy, TheDeterminantsVolumeTermLocks) {
  Table table("elements_det_volume", "model,poisson_ratio,stretch,energy_coarse,energy_fine,coarse_over_fine");
  for (const double nu : {0.3, 0.45, 0.49}) {
    for (const ElasticModel model : {ElasticModel::micropolar, ElasticModel::micropolar_det}) {
      const std::vector<double> coarse = stretch_bar(model, nu, 2, 3.0);
      const std::vector<double> fine = stretch_bar(model, nu, 4, 3.0);
      for (std::size_t i = 0; i < std::min(coarse.size(), fine.size()); ++i)
        table.row("{},{},{:.1f},{:.6f},{:.6f},{:.5f}",
                  model == ElasticModel::micropolar ? "micropolar" : "micropolar-det", nu,
                  1.1 + 0.1 * static_cast<double>(i), coarse[i], fine[i], coarse[i] / fine[i]);
      ASSERT_GE(std::min(coarse.size(), fine.size()), 3u);
      // Locking grows with Poisson's ratio.
      if (nu < 0.4) {
        EXPECT_LT(coarse[2] / fine[2], 1.05);
      } else {
        EXPECT_GT(coarse[2] / fine[2], 1.1);
      }
    }
  }
}

} // namespace
} // namespace wry::fem
