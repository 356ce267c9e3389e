#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "datapath/segment.h"
#include "formats/viewport_table.h"

namespace metabuffer {

/// Whose burst is next on a bus; arbitration_table.h says what each of them is.
enum class Arbitration : std::uint8_t { kIrsa, kSlotAllocation, kRoundRobin, kEdf };

/// What becomes of a slot that its composer cannot use.
enum class IdleSlots : std::uint8_t {
    kRecovered,  ///< the next composer that is ready has it, so the bus rests only while nobody is ready
    kLost,       ///< its time passes
};

/// What the arbiter sees of one table row at a clock.
struct BusRequest {
    bool pending = false;         ///< pixels of its segment are still to be sent
    bool ready = false;           ///< its composer's BUSREADY is high
    std::int64_t next_pixel = 0;  ///< index of the next pixel to send
};

/// An arbiter's answer for one clock.
struct BusGrant {
    enum class Kind : std::uint8_t {
        kBurst,  ///< row gets the slot
        kPoll,   ///< no composer takes a slot now: ask again at the next clock
        kLost,   ///< the slot's owner cannot use it and nobody else may: its time passes
    };
    Kind kind = Kind::kPoll;
    int row = -1;
    int recovered_slots = 0;  ///< slots passed over on the way to the one granted
};

/// Chooses whose burst the bus carries next (section 5.3 of the paper). State without time: the input
/// framebuffer asks once a clock while no burst is under way.
class ArbitrationPolicy {
  public:
    ArbitrationPolicy() = default;
    ArbitrationPolicy(const ArbitrationPolicy&) = delete;
    ArbitrationPolicy& operator=(const ArbitrationPolicy&) = delete;
    virtual ~ArbitrationPolicy() = default;

    /// A new frame's segments, in table order. Requests are indexed alike.
    virtual void start_frame(const std::vector<Segment>& segments) = 0;
    /// At least one request is pending.
    virtual BusGrant pick(const std::vector<BusRequest>& requests) = 0;
    /// Position in the slot table, for waveforms; 0 where there is none.
    virtual int slot() const { return 0; }
};

/// The policy that bus.arbitration names.
std::unique_ptr<ArbitrationPolicy> make_policy(Arbitration arbitration);

}  // namespace metabuffer
