#include "diagnosis/groups.h"

#include <algorithm>

namespace mm {

bool inModel(const Model& model, const EffectSpec& spec) {
  return std::any_of(model.effects().begin(), model.effects().end(),
                     [&](const EffectPtr& e) { return e->spec() == spec; });
}

std::string causeOf(const Effect& effect) {
  const std::vector<std::string> shape = effect.nature().shapeKeys;
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

}  // namespace mm
