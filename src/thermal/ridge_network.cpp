#include "thermal/ridge_network.h"

#include <sstream>

#include "thermal/numbers.h"

namespace mm {

void RidgeNetwork::learn(int /*from*/) {
  const RidgeValidation validation = validateRidge(x_, y_, blockedFolds(samples(), blocks()), ridgeLadder());
  heldOut_ = validation.rms;
  model_ = fitRidge(x_, y_, validation.lambda);
}

void RidgeNetwork::evaluate(const double* x, double* y) const {
  for (int o = 0; o < outputs(); ++o) {
    y[o] = model_.offset(o);
    for (int i = 0; i < inputs(); ++i) y[o] += model_.slopes(i, o) * x[i];
  }
}

std::string RidgeNetwork::describe() const {
  std::ostringstream text;
  text << "ridge: linear, " << samples() << " samples, ridge " << model_.lambda << ", held-out error "
       << heldOut_;
  return text.str();
}

void RidgeNetwork::write(std::vector<double>& numbers) const {
  numbers.push_back(model_.lambda);
  numbers.push_back(heldOut_);
  writeMatrix(numbers, model_.offset);
  writeMatrix(numbers, model_.slopes);
}

void RidgeNetwork::read(const double*& next, const double* end) {
  model_.lambda = readNumber(next, end);
  heldOut_ = readNumber(next, end);
  model_.offset = readMatrix(next, end, outputs(), 1);
  model_.slopes = readMatrix(next, end, inputs(), outputs());
}

}  // namespace mm
