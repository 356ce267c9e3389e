#pragma once

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace metabuffer {

/// Work done in a separate process, which sends bytes through a pipe and waits while nobody reads. SystemC elaborates
/// only once in a process, and a crash there does no harm here.
class ChildProcess {
  public:
    /// The child's end of the pipe.
    class Sender {
      public:
        explicit Sender(int descriptor) : descriptor_(descriptor) {}
        /// Ends the process if nobody reads any more.
        void send(const void* bytes, std::size_t count) const;
        int descriptor() const { return descriptor_; }

      private:
        int descriptor_;
    };
    using Work = std::function<void(const Sender&)>;

    /// Starts it. The child ends when `work` returns, and dies with this process. An exception from `work` ends it as a
    /// failure. Construct it before this process elaborates anything. Throws InputError if this computer cannot start
    /// the process.
    explicit ChildProcess(const Work& work);
    /// Ends the child if it still runs.
    ~ChildProcess();
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    /// Whether everything has been received and nothing more comes.
    bool ended() const { return descriptor_ < 0; }
    /// To poll for reading until it has ended.
    int descriptor() const { return descriptor_; }
    /// Appends the bytes that have come; waits if there are none.
    void receive(std::string& bytes);
    /// Sends the child SIGTERM, unless all has been received.
    void ask_to_end() const;
    /// Once it has ended: empty if it ended well, else how it ended ("ended by a signal: Aborted").
    const std::string& complaint() const { return complaint_; }

  private:
    void reap();

    pid_t process_ = -1;
    int descriptor_ = -1;
    std::string complaint_;
};

/// Closes all descriptors of this process but the standard ones and these: for a child, which would keep its parent's pipes
/// open otherwise.
void close_descriptors_but(std::vector<int> kept);

/// How many processes should help this one: one for each core of this computer, none if there is only one.
std::size_t helper_process_count();

}  // namespace metabuffer
