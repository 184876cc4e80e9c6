#pragma once

namespace CLI {
class App;
}

namespace mm {

/// A program as it is typed: what it throws becomes one line that begins with its name, and the exit status;
/// Ctrl-C asks for the end (Interrupt), effects of plugins are loaded before it works.
/// @param exitStatus that its command has set when it has run.
int runProgram(CLI::App& app, const int& exitStatus, int argc, char** argv);

}  // namespace mm
