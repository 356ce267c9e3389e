#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace metabuffer {

/// Whose burst is next on a bus; arbitration_table.h describes each policy.
enum class Arbitration : std::uint8_t { kIrsa, kSlotAllocation, kRoundRobin, kEdf };

/// What happens to a slot that its composer cannot use.
enum class IdleSlots : std::uint8_t {
    kRecovered,  ///< the next composer that is ready gets it, so the bus rests only while none is ready
    kLost,       ///< its time passes
};

/// What the arbiter sees of one table row at a clock.
struct BusRequest {
    bool pending = false;       ///< pixels of its segment are still to be sent
    bool ready = false;         ///< its composer takes a slot
    std::int64_t deadline = 0;  ///< first raster position that needs its next pixel; for policies that use it
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

/// Chooses whose burst the bus carries next (section 5.3 of the paper). It has state but no time: the input framebuffer
/// takes an answer in each clock in which no burst is under way.
class ArbitrationPolicy {
  public:
    ArbitrationPolicy() = default;
    ArbitrationPolicy(const ArbitrationPolicy&) = delete;
    ArbitrationPolicy& operator=(const ArbitrationPolicy&) = delete;
    virtual ~ArbitrationPolicy() = default;

    /// A new frame: which row owns each slot (slots_of in arbitration_table.h), and how many rows its table has.
    /// Requests are indexed like the rows.
    virtual void start_frame(const std::vector<int>& slots, std::size_t rows) = 0;
    /// The answer for a clock, which changes nothing. At least one request is pending.
    virtual BusGrant grant(const std::vector<BusRequest>& requests) const = 0;
    /// The clock's answer has been taken.
    virtual void take(const BusGrant& /*grant*/) {}
    BusGrant pick(const std::vector<BusRequest>& requests) {
        const BusGrant answer = grant(requests);
        take(answer);
        return answer;
    }
    /// The slot that is checked first; 0 where there is none.
    virtual int slot() const { return 0; }
};

/// The policy that bus.arbitration names.
std::unique_ptr<ArbitrationPolicy> make_policy(Arbitration arbitration);

}  // namespace metabuffer
