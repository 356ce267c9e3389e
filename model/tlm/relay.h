#pragma once

#include <functional>
#include <utility>

namespace metabuffer::tlm {

/// Carries a message along a column in a loop, from composer to composer. Otherwise each composer would call the next
/// from within its own transport method, and in a column of 65,536 composers these nested calls overflow the stack.
///
/// A message has one receiver at a time: while a hop is under way, at most one further hop may be asked for.
class Relay {
  public:
    using Hop = std::function<void()>;

    /// Outside a hop: makes the hop and all that it asks for, and returns when the message has arrived. Within a hop:
    /// makes the new hop as soon as the current one has returned.
    void pass(Hop hop) {
        next_ = std::move(hop);
        if (is_running_) return;
        is_running_ = true;
        while (next_) std::exchange(next_, nullptr)();
        is_running_ = false;
    }

  private:
    Hop next_;
    bool is_running_ = false;
};

/// The messages along a column's pipeline; each kind has its own relay.
struct ColumnRelays {
    Relay pipeready;   ///< up
    Relay startframe;  ///< down
    Relay pixels;      ///< down
};

}  // namespace metabuffer::tlm
