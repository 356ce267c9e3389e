#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/program/exit_status.h"

namespace metabuffer::python {

/// What a call of the model returns: the program's status, and a text. With kExitDone the text is the result. With
/// kExitWatchdog and kExitDifferent it is a result, too, which says what is wrong. Otherwise it is a message of one
/// line.
struct Reply {
    ExitStatus status = kExitDone;
    std::string text;
};

/// Does the work in a process of its own, and waits for it without the interpreter's lock. An exception of the work
/// comes back as the message and status that the program would have. kExitModelError is an error that the model
/// reports, or with `crashed` in the result a process that ended without a reply.
///
/// SystemC elaborates once in a process and the model may crash. Neither matters to the interpreter, since none of the
/// model's code runs in its process. So it may have threads, and several of them may call at once: at the fork no lock
/// of the model's is held, and the C library handles its own. The child never calls Python, keeps no file open but the
/// standard ones and `kept_descriptors`, and dies with its parent.
///
/// If a signal's handler in Python raises, as Ctrl-C's does, this function asks the process to end, waits a while, ends
/// it, and throws what the handler has raised. Only Python's main thread runs handlers.
struct CallResult {
    Reply reply;
    bool crashed = false;
};
CallResult call_in_process(const std::function<Reply()>& work, const std::vector<int>& kept_descriptors = {});

}  // namespace metabuffer::python
