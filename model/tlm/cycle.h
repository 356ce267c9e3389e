#pragma once

#include <cstdint>
#include <string>
#include <systemc>

namespace metabuffer::tlm {

/// A clock domain as arithmetic: edge n of a clock with the given period is at n periods, edge 0 at time 0.
class ClockDomain {
  public:
    explicit ClockDomain(std::int64_t period_picoseconds) : period_(period_picoseconds) {}

    std::int64_t period_picoseconds() const { return period_; }
    std::int64_t picoseconds_of(std::int64_t edge) const { return edge * period_; }
    /// The last edge at or before a time.
    std::int64_t edge_at(std::int64_t picoseconds) const { return picoseconds / period_; }
    /// The first edge at or after a time.
    std::int64_t edge_from(std::int64_t picoseconds) const { return (picoseconds + period_ - 1) / period_; }
    /// The edge at which a level that another domain changed at that time has passed the two registers of
    /// this domain. A change at an edge is captured by the next one.
    std::int64_t edge_seeing(std::int64_t picoseconds) const { return edge_at(picoseconds) + 2; }
    /// Time from now to an edge. Raises /metabuffer/tlm/past if that has passed.
    sc_core::sc_time until(std::int64_t edge) const {
        if (picoseconds_of(edge) < static_cast<std::int64_t>(sc_core::sc_time_stamp().value())) {
            SC_REPORT_ERROR("/metabuffer/tlm/past",
                            ("clock " + std::to_string(edge) + " has passed").c_str());
        }
        return sc_core::sc_time::from_value(static_cast<sc_dt::uint64>(picoseconds_of(edge))) -
               sc_core::sc_time_stamp();
    }

  private:
    std::int64_t period_;
};

inline std::int64_t now_picoseconds() { return static_cast<std::int64_t>(sc_core::sc_time_stamp().value()); }

}  // namespace metabuffer::tlm
