#pragma once

namespace mm {

/// The last of a job (config/batch/Snakefile): judges what its steps left in the current folder, which
/// ResultsFolder::begin made, writes result.json, and moves the folder to its place. @return exit status.
/// @throw InputError: the result cannot be written.
int writeBatchResult();

}  // namespace mm
