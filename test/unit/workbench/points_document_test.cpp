// The residual that the page draws along an axis, against the report's and against the sign that was hidden.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench_fixture.h"
#include "report/report_variables.h"
#include "workbench/session_documents.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

using nlohmann::json;

CalibrationResult nominalFit(const Session& session) {
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  options.rejectOutliers = false;
  return calibrate(session, modelFor(session, {}), options);
}

const json& column(const json& points, const std::string& name) {
  for (const json& c : points["columns"])
    if (c["name"] == name) return c["values"];
  throw std::out_of_range(name);
}

TEST(PointsDocument, ResidualsOfContactsHaveTheSignOfTheReport) {
  const CalibrationResult fit = nominalFit(test::plate());
  const json points = json::parse(pointsDocument(fit, {}));
  const json &along = column(points, "residual along x"), &travel = column(points, "x travel direction");
  double sum[2] = {0.0, 0.0};
  int count[2] = {0, 0};
  for (std::size_t r = 0; r < along.size(); ++r) {
    if (along[r].is_null() || travel[r].is_null()) continue;
    sum[travel[r].get<int>()] += along[r].get<double>();
    ++count[travel[r].get<int>()];
  }
  const auto views = residualsByVariable(fit, nullptr, {});
  const auto view = std::find_if(views.begin(), views.end(),
                                 [](const VariableView& v) { return v.name == "x travel direction"; });
  ASSERT_NE(view, views.end());
  ASSERT_EQ(view->direction, "x");
  ASSERT_EQ(view->bins.size(), 2u);
  for (int level = 0; level < 2; ++level) {
    double drawn = 0.0;
    int drawnCount = 0;
    for (std::size_t i = 0; i < view->x.size(); ++i)
      if (view->x[i] == level) drawn += view->y[i], ++drawnCount;
    ASSERT_EQ(drawnCount, count[level]);
    EXPECT_NEAR(sum[level] / drawnCount, drawn / drawnCount, 1e-3);
    const double behind = level == 0 ? 1.0 : -1.0;  // a slide with play stops short of where its scale says
    EXPECT_GT(behind * drawn / drawnCount, 0.5);
    EXPECT_GT(behind * view->bins[static_cast<std::size_t>(level)].mean, 0.5);
  }
}

TEST(PointsDocument, ResidualsOfDeviationsAreMeasuredMinusModel) {
  Session session(Machine::load("three_axis"));
  for (int i = 0; i < 20; ++i) {
    Observation o;
    o.kind = ObservationKind::kDeviation;
    o.time = i;
    o.row = i + 2;
    o.position = {1e-3 * i, 0.0, 0.0};
    o.velocity = {1e-3, 0.0, 0.0};
    o.deviation = {0.04e-6 * i, kNotMeasured, kNotMeasured};  // it goes too far
    session.observations.push_back(o);
  }
  session.prepare();
  const CalibrationResult fit = nominalFit(session);
  const json points = json::parse(pointsDocument(fit, {}));
  const json &along = column(points, "residual along x"), &residual = column(points, "residual");
  EXPECT_EQ(along, residual);
  EXPECT_GT(along[19].get<double>() - along[0].get<double>(), 0.5);
}

}  // namespace
}  // namespace mm
