#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/program/exit_status.h"

namespace metabuffer::python {

/// What a call of the model gives: a status as the program's, and a text. kExitDone: the result. kExitWatchdog and
/// kExitDifferent: a result, too, which says what is wrong. Else a message of one line.
struct Reply {
    ExitStatus status = kExitDone;
    std::string text;
};

/// Does the work in a process of its own, and waits for it without the interpreter's lock. What the work throws comes
/// back as the message and status that the program would have. kExitModelError stands for what the model reports;
/// `crashed` of the result for a process that ended without a reply.
///
/// SystemC elaborates once in a process and the model may crash: neither matters to the interpreter, since none of the
/// model's code runs in its process. So it may have threads, and several of them may call at once: at the fork no lock
/// of the model's is held, and the C library sees to its own. The child never calls Python, keeps no file open but the
/// standard ones and `kept_descriptors`, and dies with its parent.
///
/// A signal whose handler in Python raises, as Ctrl-C's does, asks the process to end, waits a while, ends it, and throws
/// what the handler has raised. Only Python's main thread runs handlers.
struct CallResult {
    Reply reply;
    bool crashed = false;
};
CallResult call_in_process(const std::function<Reply()>& work, const std::vector<int>& kept_descriptors = {});

}  // namespace metabuffer::python
