#pragma once

namespace metabuffer {

/// What the program tells its caller.
enum ExitStatus : int {
    kExitDone = 0,
    kExitModelError = 1,  ///< a block found its protocol broken: a bug in the model
    kExitBadInput = 2,    ///< scenario, images or command line, a place that cannot be written among them
    kExitStrict = 3,      ///< --strict, and something starved or was rejected
    kExitWatchdog = 4,    ///< nothing moved any more (of compare: the levels agree on that, so it is done)
    kExitDifferent = 5,   ///< compare: the levels differ; run --check: the level breaks a rule
    kExitIncomplete = 6,  ///< merge: points of the sweep are missing
    kExitStopped = 130,   ///< sweep and size: stopped by Ctrl-C, as shells put it
};

}  // namespace metabuffer
