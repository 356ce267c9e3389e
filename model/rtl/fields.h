#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>
#include <string>
#include <systemc>
#include <type_traits>

/// A structure that a signal carries lists its fields once. The list gives ==, << and sc_trace, as sc_signal needs:
///
///     template <typename See>
///     static void visit_fields(const See& see, int address_bits = kAllBits) {
///         see("enable", &FifoRead::enable);
///         see("address", &FifoRead::address, address_bits);
///     }
///
/// The list calls see() for each field, in the waveform's order, in one of two forms:
///
/// - see(name in the waveform, pointer to member or function that gives the field, bits)
/// - see(name, array, member with the number of elements that mean something, elements in the waveform, bits of each)
///
/// Parameters after `see`, such as address_bits, are passed by sc_trace: widths that depend on the signal.
namespace metabuffer::rtl {

/// For `bits`: as many as the field's type has; none, since the field is not in the waveform.
constexpr int kAllBits = -1;
constexpr int kUntraced = 0;

template <typename Field>
constexpr bool kIsNumber = std::is_integral_v<Field> || std::is_enum_v<Field>;

/// Adds a number, a flag or an enumeration to a waveform, `width_bits` wide. is_signed: it may be negative. A
/// number that does not fit, or is negative without that, shows as x.
template <typename Value>
void trace_number(sc_core::sc_trace_file* file, const Value& value, const std::string& name, int width_bits,
                  bool is_signed = false) {
    if constexpr (std::is_same_v<Value, bool>) {
        sc_core::sc_trace(file, value, name);
    } else if constexpr (std::is_enum_v<Value>) {
        static_assert(sizeof(Value) == 1);
        sc_core::sc_trace(file, reinterpret_cast<const unsigned char&>(value), name, width_bits);
    } else if (std::is_signed_v<Value> && is_signed) {
        sc_core::sc_trace(file, value, name, width_bits);
    } else {
        // Numbers that are never negative may be read as unsigned.
        using Bits = std::make_unsigned_t<Value>;
        sc_core::sc_trace(file, reinterpret_cast<const Bits&>(value), name, width_bits);
    }
}

/// Adds the first `lanes` of an array's values to a waveform, as NAME_0, NAME_1, ...
template <typename Value, std::size_t kLanes>
void trace_lanes(sc_core::sc_trace_file* file, const std::array<Value, kLanes>& values, int lanes,
                 const std::string& name, int width_bits = 8 * sizeof(Value)) {
    for (int lane = 0; lane < lanes; ++lane) {
        sc_core::sc_trace(file, values[static_cast<std::size_t>(lane)], name + "_" + std::to_string(lane),
                          width_bits);
    }
}

template <typename Value>
struct FieldComparison {
    const Value& a;
    const Value& b;
    bool& equal;

    template <typename Name, typename Access>
    void operator()(const Name& /*name*/, const Access& access, int /*bits*/ = kAllBits) const {
        equal = equal && std::invoke(access, a) == std::invoke(access, b);
    }
    template <typename Array, typename Count>
    void operator()(const char* /*name*/, Array Value::*array, Count Value::*count, int /*lanes*/,
                    int /*bits*/ = kAllBits) const {
        const auto& words = a.*array;
        equal = equal && std::equal(words.begin(), words.begin() + a.*count, (b.*array).begin());
    }
};

template <typename Value>
struct FieldPrinter {
    const Value& value;
    std::ostream& out;

    template <typename Name, typename Access>
    void operator()(const Name& name, const Access& access, int /*bits*/ = kAllBits) const {
        print(name, std::invoke(access, value));
    }
    template <typename Array, typename Count>
    void operator()(const char* name, Array Value::*array, Count Value::*count, int /*lanes*/,
                    int /*bits*/ = kAllBits) const {
        for (std::size_t i = 0; i < value.*count; ++i)
            print(name + ('_' + std::to_string(i)), (value.*array)[i]);
    }
    template <typename Name, typename Field>
    void print(const Name& name, const Field& field) const {
        if constexpr (kIsNumber<Field>) {
            if (field != Field{}) out << ' ' << name << '=' << static_cast<std::int64_t>(field);
        }
    }
};

template <typename Value>
struct FieldTracer {
    const Value& value;
    sc_core::sc_trace_file* file;
    const std::string& prefix;

    template <typename Name, typename Access>
    void operator()(const Name& name, const Access& access, int bits = kAllBits) const {
        const auto& field = std::invoke(access, value);
        if constexpr (kIsNumber<std::decay_t<decltype(field)>>) {
            constexpr int kTypeBits = 8 * sizeof(field);
            if (bits != kUntraced) {
                trace_number(file, field, prefix + '.' + name, bits == kAllBits ? kTypeBits : bits, true);
            }
        }
    }
    template <typename Array, typename Count>
    void operator()(const char* name, Array Value::*array, Count Value::* /*count*/, int lanes,
                    int bits = kAllBits) const {
        constexpr int kTypeBits = 8 * sizeof(typename Array::value_type);
        trace_lanes(file, value.*array, lanes, prefix + '.' + name, bits == kAllBits ? kTypeBits : bits);
    }
};

/// Exists for structures that have such a list.
template <typename Value, typename... Bits>
using HasFields = decltype(Value::visit_fields(0, Bits{}...));

// Flattened, since every write to a signal compares: as calls it takes a tenth of a whole run.
template <typename Value, typename = HasFields<Value>>
[[gnu::flatten]] inline bool operator==(const Value& a, const Value& b) {
    bool equal = true;
    Value::visit_fields(FieldComparison<Value>{a, b, equal});
    return equal;
}

/// Prints the fields that are not zero.
template <typename Value, typename = HasFields<Value>>
std::ostream& operator<<(std::ostream& out, const Value& value) {
    out << '{';
    Value::visit_fields(FieldPrinter<Value>{value, out});
    return out << " }";
}

/// As NAME and the fields' names, with a dot between them.
template <typename Value, typename... Bits, typename = HasFields<Value, Bits...>>
void sc_trace(sc_core::sc_trace_file* file, const Value& value, const std::string& name, Bits... bits) {
    Value::visit_fields(FieldTracer<Value>{value, file, name}, bits...);
}

}  // namespace metabuffer::rtl

namespace metabuffer {

// Found by the namespace of their arguments: plain structures of model/formats and model/datapath have lists, too.
using rtl::operator==;
using rtl::operator<<;
using rtl::sc_trace;

}  // namespace metabuffer
