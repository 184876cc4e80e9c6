#include "effects/expression.h"

#include <muParser.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/pattern.h"
#include "base/units.h"

namespace mm {
namespace {

bool isUnknown(const std::string& name) {
  return name.size() > 1 && name.size() < 8 && name[0] == 'k' && name[1] != '0' &&
         std::all_of(name.begin() + 1, name.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// An assignment would change a variable behind the model's back.
void refuseAssignment(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    if (i + 1 < text.size() && text[i + 1] == '=') {
      ++i;
      continue;
    }
    if (i > 0 && (text[i - 1] == '<' || text[i - 1] == '>' || text[i - 1] == '!')) continue;
    throw InputError("'=' at position " + std::to_string(i + 1) +
                     ": a formula is an expression, without assignment");
  }
}

void defineConstants(mu::Parser& parser, const std::vector<std::string>& taken) {
  if (std::find(taken.begin(), taken.end(), "pi") == taken.end()) parser.DefineConst("pi", kPi);
  if (std::find(taken.begin(), taken.end(), "e") == taken.end()) parser.DefineConst("e", std::exp(1.0));
}

std::string inWords(const mu::ParserError& error, const std::string& text) {
  std::string message = Pattern("( at position \\d+)|\\.").removedFrom(error.GetMsg());
  std::replace(message.begin(), message.end(), '\n', ' ');
  const int length = static_cast<int>(text.size());
  const int position = error.GetPos() < 0 ? length : std::min(error.GetPos(), length);
  return "syntax: " + message + " (near position " + std::to_string(position) + " of '" + text + "')" +
         (text.find("**") != std::string::npos ? "; powers are written ^" : "");
}

}  // namespace

struct Expression::Evaluation::Compiled {
  mu::Parser parser;
  std::vector<double> variables, unknowns;
};

Expression::Expression(const std::string& text, std::vector<std::string> variables) : text_(text) {
  refuseAssignment(text);
  std::vector<std::string> found;
  try {
    mu::Parser parser;
    defineConstants(parser, variables);
    parser.SetExpr(text);
    for (const auto& entry : parser.GetUsedVar()) found.push_back(entry.first);
  } catch (const mu::ParserError& error) {
    throw InputError(inWords(error, text));
  }
  for (const std::string& name : found) {
    const auto known = std::find(variables.begin(), variables.end(), name);
    const bool twice =
        known != variables.end() && std::find(known + 1, variables.end(), name) != variables.end();
    if (twice || (known != variables.end() && isUnknown(name)))
      throw InputError("'" + name + "' means two things in this session; rename one of them");
    if (known != variables.end()) {
      used_.push_back(static_cast<int>(known - variables.begin()));
      names_.push_back(name);
    } else if (isUnknown(name)) {
      unknowns_.push_back(name);
    } else {
      throw InputError("unknown variable '" + name + "'; known: " + listOf(variables) +
                       ", the constants pi and e, the unknowns k1, k2 …" + didYouMean(name, variables));
    }
  }
  std::sort(unknowns_.begin(), unknowns_.end(), [](const std::string& a, const std::string& b) {
    return std::stol(a.substr(1)) < std::stol(b.substr(1));
  });
  if (unknowns_.empty())
    throw InputError("nothing to estimate in '" + text + "'; write its unknowns as k1, k2 …");
  pool_.push_back(compile());
}

Expression::~Expression() = default;

std::unique_ptr<Expression::Evaluation::Compiled> Expression::compile() const {
  auto compiled = std::make_unique<Evaluation::Compiled>();
  compiled->variables.assign(names_.size(), 1.0);
  compiled->unknowns.assign(unknowns_.size(), 1.0);
  try {
    for (std::size_t i = 0; i < names_.size(); ++i)
      compiled->parser.DefineVar(names_[i], &compiled->variables[i]);
    for (std::size_t i = 0; i < unknowns_.size(); ++i)
      compiled->parser.DefineVar(unknowns_[i], &compiled->unknowns[i]);
    defineConstants(compiled->parser, names_);
    compiled->parser.SetExpr(text_);
    int results = 0;
    compiled->parser.Eval(results);
    if (results != 1)
      throw InputError("'" + text_ + "' gives " + std::to_string(results) + " values; write one expression");
  } catch (const mu::ParserError& error) {
    throw InputError(inWords(error, text_));
  }
  return compiled;
}

Expression::Evaluation::Evaluation(const Expression& owner) : owner_(owner) {
  {
    const std::lock_guard<std::mutex> lock(owner.mutex_);
    if (!owner.pool_.empty()) {
      compiled_ = std::move(owner.pool_.back());
      owner.pool_.pop_back();
    }
  }
  if (!compiled_) compiled_ = owner.compile();
}

Expression::Evaluation::~Evaluation() {
  const std::lock_guard<std::mutex> lock(owner_.mutex_);
  owner_.pool_.push_back(std::move(compiled_));
}

double* Expression::Evaluation::variables() { return compiled_->variables.data(); }

double Expression::Evaluation::operator()(const double* unknowns) const {
  for (const double value : compiled_->variables)
    if (std::isnan(value)) return std::numeric_limits<double>::quiet_NaN();
  std::copy(unknowns, unknowns + compiled_->unknowns.size(), compiled_->unknowns.begin());
  return compiled_->parser.Eval();
}

}  // namespace mm
