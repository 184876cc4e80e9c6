// Effects that are wrong, each in its own way.
#include <measuring_machine/effect_plugin.h>

#include <pluginlib/class_list_macros.hpp>

namespace bad_effects {

using mm::plugin::Key;
using mm::plugin::Keys;
using mm::plugin::Session;

class Constant : public mm::plugin::Effect {
 public:
  std::vector<mm::plugin::Parameter> parameters() const override {
    mm::plugin::Parameter size;
    size.name = "size";
    size.unit = "um";
    size.toUnit = 1e6;
    size.scale = 1e-6;
    size.bound = 1e-3;
    return {size};
  }
  void evaluate(const mm::plugin::State& s, const double* p, mm::plugin::Error& e) const override {
    e.reading[0] += p[0] * s.position[0] * s.position[0] * 1e4;
  }
  std::string cause() const override { return "a test"; }
  std::string remedy() const override { return "none"; }
  std::string shownBy() const override { return "anything"; }
};

class AtWork : public Constant {
  void evaluate(const mm::plugin::State&, const double*, mm::plugin::Error&) const override {
    throw std::runtime_error("the table of loads is empty");
  }
};

class Square : public Constant {
  void evaluate(const mm::plugin::State&, const double* p, mm::plugin::Error& e) const override {
    e.reading[0] += p[0] * p[0];
  }
};

/// One type a class: `name`, what create() does.
template <class E>
class Type : public mm::plugin::EffectType {
 public:
  explicit Type(std::string name) : name_(std::move(name)) {}
  std::string name() const override { return name_; }
  std::vector<Key> keys() const override { return {}; }
  std::unique_ptr<mm::plugin::Effect> create(const Keys&, const Session&) const override {
    return std::make_unique<E>();
  }
  std::vector<Keys> candidates(const Session&) const override { return {{}}; }

 private:
  std::string name_;
};

struct Taken : Type<Constant> {
  Taken() : Type("backlash") {}
};
struct ThrowsAtOnce : Type<Constant> {
  ThrowsAtOnce() : Type("throws_at_once") { throw std::runtime_error("no licence file"); }
};
struct ThrowsInCreate : Type<Constant> {
  ThrowsInCreate() : Type("throws_in_create") {}
  std::unique_ptr<mm::plugin::Effect> create(const Keys&, const Session&) const override {
    throw std::runtime_error("no such bearing");
  }
};
struct ThrowsAtWork : Type<AtWork> {
  ThrowsAtWork() : Type("throws_at_work") {}
};
struct NotLinear : Type<Square> {
  NotLinear() : Type("not_linear") {}
};
struct Old : Type<Constant> {
  Old() : Type("old") {}
  int builtWith() const override { return 0; }
};

}  // namespace bad_effects

PLUGINLIB_EXPORT_CLASS(bad_effects::Taken, mm::plugin::EffectType)
PLUGINLIB_EXPORT_CLASS(bad_effects::ThrowsAtOnce, mm::plugin::EffectType)
PLUGINLIB_EXPORT_CLASS(bad_effects::ThrowsInCreate, mm::plugin::EffectType)
PLUGINLIB_EXPORT_CLASS(bad_effects::ThrowsAtWork, mm::plugin::EffectType)
PLUGINLIB_EXPORT_CLASS(bad_effects::NotLinear, mm::plugin::EffectType)
PLUGINLIB_EXPORT_CLASS(bad_effects::Old, mm::plugin::EffectType)
