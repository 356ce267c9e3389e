#pragma once

#include <systemc>
#include <type_traits>
#include <vector>

namespace metabuffer::rtl {

class Clocked;

/// What a Clocked sees of a Wire that is an input of its module.
class WakingWire {
  public:
    /// The method sleeps: a change wakes it.
    void add_sleeper(Clocked& sleeper) {
        ++heard_;
        sleepers_.push_back(&sleeper);
    }
    void remove_sleeper(Clocked& sleeper);
    /// At each change what is combinational in its module is evaluated.
    void add_follower(Clocked& follower) {
        ++heard_;
        followers_.push_back(&follower);
    }

  protected:
    WakingWire() = default;
    ~WakingWire() = default;
    bool is_heard() const { return heard_ > 0; }
    void note_change();

    // Of the Wire. They are here to lie beside its values.
    bool written_ = false;  ///< in this delta cycle
    bool changes_ = false;  ///< by what was written last

  private:
    int heard_ = 0;  ///< sleepers and followers
    std::vector<Clocked*> sleepers_;
    std::vector<Clocked*> followers_;
};

/// A signal between two blocks of a machine. It wakes clocked methods that sleep, and has what is combinational evaluated,
/// without an event, which would take time at every change. One port may drive it, as any sc_signal; that is checked at
/// elaboration.
template <typename Value>
class Wire final : public sc_core::sc_signal<Value>, public WakingWire {
  public:
    using sc_core::sc_signal<Value>::sc_signal;

    const Value& read() const override { return this->m_cur_val; }
    void write(const Value& value) override {
        const bool changes = !(value == this->m_cur_val);
        if (!changes && !written_) return;
        this->m_new_val = value;
        changes_ = changes;
        if (!written_) this->request_update();
        written_ = true;
    }

  protected:
    void update() override {
        written_ = false;
        if (!changes_) return;
        if (has_events()) {
            this->do_update();
        } else {
            this->m_cur_val = this->m_new_val;
        }
        if (is_heard()) note_change();
    }

  private:
    bool has_events() const {
        if constexpr (std::is_same_v<Value, bool>) {
            if (this->m_posedge_event_p != nullptr || this->m_negedge_event_p != nullptr) return true;
        }
        return this->m_change_event_p != nullptr;
    }
};

}  // namespace metabuffer::rtl
