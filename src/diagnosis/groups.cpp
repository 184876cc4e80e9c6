#include "diagnosis/groups.h"

#include <algorithm>
#include <numeric>

namespace mm {

bool inModel(const Model& model, const EffectSpec& spec) {
  return std::any_of(model.effects().begin(), model.effects().end(),
                     [&](const EffectPtr& e) { return e->spec() == spec; });
}

std::string causeOf(const Effect& effect) {
  const std::vector<std::string> shape = effect.shapeKeys();
  std::string key = effect.spec().type;
  for (const auto& [name, value] : effect.spec().keys) {
    if (std::find(shape.begin(), shape.end(), name) != shape.end()) continue;
    key += " " + name;
    for (const std::string& item : value.items) key += " " + item;
  }
  return key;
}

void append(Groups& to, Groups more) {
  const int before = static_cast<int>(to.columns.cols());
  RowMatrix all(std::max(to.columns.rows(), more.columns.rows()), before + more.columns.cols());
  if (before > 0) all.leftCols(before) = to.columns;
  if (more.columns.cols() > 0) all.rightCols(more.columns.cols()) = more.columns;
  to.columns = std::move(all);
  for (Group& g : more.groups) {
    for (Shape& s : g.shapes) s.first += before;
    to.groups.push_back(std::move(g));
  }
  to.notShown.insert(to.notShown.end(), more.notShown.begin(), more.notShown.end());
}

Groups oneOf(const Groups& all, std::size_t group, const std::vector<int>& shapes) {
  Groups one;
  one.groups.push_back(all.groups[group]);
  std::vector<Shape>& kept = one.groups[0].shapes;
  kept.clear();
  int count = 0;
  for (const int s : shapes) count += all.groups[group].shapes[s].count;
  one.columns.resize(all.columns.rows(), count);
  int at = 0;
  for (const int s : shapes) {
    Shape shape = all.groups[group].shapes[s];
    one.columns.middleCols(at, shape.count) = all.columns.middleCols(shape.first, shape.count);
    shape.first = at;
    at += shape.count;
    kept.push_back(std::move(shape));
  }
  one.causes = !one.groups[0].profile;
  return one;
}

Groups oneOf(const Groups& all, std::size_t group) {
  std::vector<int> shapes(all.groups[group].shapes.size());
  std::iota(shapes.begin(), shapes.end(), 0);
  return oneOf(all, group, shapes);
}

}  // namespace mm
