#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace metabuffer {

/// Messages in both directions between this process and a child that it forks later. Each message is received whole.
class MessageChannel {
  public:
    static constexpr std::size_t kMostBytes =
        16384;  ///< of a message: a path, or a line that says what is wrong

    /// Throws InputError if this computer has no descriptors for it.
    MessageChannel();
    MessageChannel(const MessageChannel&) = delete;
    MessageChannel& operator=(const MessageChannel&) = delete;
    ~MessageChannel();

    /// Call one of these once, after the fork, to say which of the two this process is. From then on the other end
    /// closes with the other process.
    void be_parent() { keep(0); }
    void be_child() { keep(1); }

    /// To poll for reading.
    int descriptor() const { return ends_[own_]; }
    /// False if nobody receives any more.
    bool send(std::string_view message) const;
    /// Waits for the next message; messages that a process sent before it ended still come. Empty: no more will come.
    std::string receive() const;

  private:
    void keep(std::size_t end);

    std::array<int, 2> ends_{-1, -1};
    std::size_t own_ = 0;
};

/// From now on what this process writes to its standard error is discarded.
void be_silent();

/// Does the work, and reports in a message how it ended.
std::string ending_of(const std::function<void()>& work);

/// The result of the other process's work: true if it is done. Throws the InputError or the OutputError that the work
/// threw. False if it failed for another reason, such as memory, or if the message is empty because the process has
/// ended: then nothing more is known, and this process may try the same.
bool is_done(const std::string& ending);

}  // namespace metabuffer
