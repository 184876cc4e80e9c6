#pragma once
#include <filesystem>

#include "fleet/job.h"
#include "fleet/job_result.h"
#include "tools/step_process.h"

namespace mm {

/// Does the jobs of one chunk in turn, each into its folder; says in the chunk's file which ended. Jobs that
/// are finished already are passed over. @param limit s that a step may take. @return exit status: done, or
/// stopped by Ctrl-C. @throw InputError: the chunk cannot be read; at the end, that results of some jobs
/// could not be written.
int doChunk(const std::filesystem::path& chunk, MmProgram program, int limit);

}  // namespace mm
