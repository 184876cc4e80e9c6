#pragma once

namespace CLI {
class App;
}

namespace mm {

/// `mm plan verify`, a command of `mm plan`. @throw InputError from its callback.
void addPlanVerifyCommand(CLI::App& plan);

}  // namespace mm
