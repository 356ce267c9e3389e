#include "process_call.h"

#include <poll.h>
#include <pybind11/pybind11.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <memory>

#include "host/child_process.h"
#include "tools/program/failure.h"

namespace metabuffer::python {
namespace {

namespace py = pybind11;

/// How often the main thread checks for a signal that another thread has received.
constexpr int kPollMilliseconds = 100;
/// Time for an exploration to end its runs and to close its results.
constexpr std::chrono::seconds kGrace{5};

/// Blocks this thread's signals during its lifetime: between fork and begin_child() the parent's handlers would run in
/// the child.
class SignalsHeldOff {
  public:
    SignalsHeldOff() {
        sigset_t all;
        sigfillset(&all);
        pthread_sigmask(SIG_SETMASK, &all, &former_);
    }
    ~SignalsHeldOff() { pthread_sigmask(SIG_SETMASK, &former_, nullptr); }
    SignalsHeldOff(const SignalsHeldOff&) = delete;
    SignalsHeldOff& operator=(const SignalsHeldOff&) = delete;

  private:
    sigset_t former_{};
};

/// Resets the signals and closes the files that the child has from Python, so that it is like a program of its own.
void begin_child(std::vector<int> kept_descriptors) {
    for (int signal = 1; signal < NSIG; ++signal) std::signal(signal, SIG_DFL);
    // A terminal sends Ctrl-C to all of its processes; the parent decides what it means.
    std::signal(SIGINT, SIG_IGN);
    // A file that may not grow then gives its writer an error, and does not end the process.
    std::signal(SIGXFSZ, SIG_IGN);
    sigset_t none;
    sigemptyset(&none);
    pthread_sigmask(SIG_SETMASK, &none, nullptr);
    report_uncaught_exceptions();
    // Another call's pipe would not end while it is open here, and the child has no use for a notebook's sockets.
    close_descriptors_but(std::move(kept_descriptors));
}

Reply reply_of(const std::function<Reply()>& work) {
    try {
        return work();
    } catch (...) {
        const Failure failure = current_failure();
        return {failure.status, failure.message};
    }
}

std::unique_ptr<ChildProcess> started(const std::function<Reply()>& work,
                                      const std::vector<int>& kept_descriptors) {
    const SignalsHeldOff held_off;
    return std::make_unique<ChildProcess>([&](const ChildProcess::Sender& sender) {
        std::vector<int> kept = kept_descriptors;
        kept.push_back(sender.descriptor());
        begin_child(std::move(kept));
        const Reply reply = reply_of(work);
        const auto status = static_cast<std::int32_t>(reply.status);
        sender.send(&status, sizeof status);
        sender.send(reply.text.data(), reply.text.size());
    });
}

/// Waits for at most kPollMilliseconds, and appends what has come.
void receive(ChildProcess& process, std::string& received) {
    const py::gil_scoped_release released;
    pollfd entry{process.descriptor(), POLLIN, 0};
    if (poll(&entry, 1, kPollMilliseconds) > 0) process.receive(received);
}

/// After the first signal: asks the process to end, and waits for that, for kGrace, or for another signal.
void end_in_order(ChildProcess& process) {
    process.ask_to_end();
    std::string ignored;
    const auto until = std::chrono::steady_clock::now() + kGrace;
    while (!process.ended() && std::chrono::steady_clock::now() < until) {
        receive(process, ignored);
        if (PyErr_CheckSignals() != 0) {
            PyErr_Clear();
            return;
        }
    }
}

}  // namespace

CallResult call_in_process(const std::function<Reply()>& work, const std::vector<int>& kept_descriptors) {
    const std::unique_ptr<ChildProcess> process = started(work, kept_descriptors);
    std::string received;
    for (bool ended = false; !ended;) {
        ended = process->ended();
        if (!ended) receive(*process, received);
        if (PyErr_CheckSignals() != 0) {
            const py::error_already_set raised;
            end_in_order(*process);
            throw raised;
        }
    }
    std::int32_t status = 0;
    if (!process->complaint().empty()) return {{kExitModelError, process->complaint()}, true};
    if (received.size() < sizeof status) return {{kExitModelError, "ended without a reply"}, true};
    std::memcpy(&status, received.data(), sizeof status);
    received.erase(0, sizeof status);
    return {{static_cast<ExitStatus>(status), std::move(received)}, false};
}

}  // namespace metabuffer::python
