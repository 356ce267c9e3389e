#pragma once

#include "machine_run.h"

namespace metabuffer::test {

/// Checks a finished run against every rule of the hardware that holds for any machine: pictures, starved
/// pixels, pairs, bus cycles, clocks of a frame, rejections. A failure says which machine broke which rule;
/// the caller gives the machine's description with INFO.
void check_run(const MachineRun& run);

}  // namespace metabuffer::test
