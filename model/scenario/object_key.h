#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "scenario/names.h"
#include "scenario/schema.h"

/// Rows for keys: each says what files may hold there and where an object keeps it.
namespace metabuffer {

template <typename Object>
struct ObjectKey {
    SchemaKey schema;
    /// A map has none of the following members: its keys have their own rows. The value is nothing if an optional
    /// member is empty.
    std::optional<KeyValue> (*value)(const Object&) = nullptr;
    void (*set)(Object&, const KeyValue&) = nullptr;
    bool required = false;
    /// The default, if it depends on other members.
    KeyValue (*derived)(const Object&) = nullptr;
};

namespace object_key {

template <typename Type>
struct IsOptional : std::false_type {};
template <typename Type>
struct IsOptional<std::optional<Type>> : std::true_type {};

template <typename Member>
std::optional<KeyValue> value_of(const Member& member) {
    if constexpr (IsOptional<Member>::value) {
        return member ? value_of(*member) : std::nullopt;
    } else if constexpr (std::is_array_v<Member>) {
        return KeyValue(std::vector<double>(std::begin(member), std::end(member)));
    } else if constexpr (std::is_enum_v<Member>) {
        return KeyValue(std::string(to_string(member)));
    } else if constexpr (std::is_integral_v<Member>) {
        return KeyValue(static_cast<std::int64_t>(member));
    } else {
        return KeyValue(member);
    }
}

template <typename Member>
void assign(Member& member, const KeyValue& value) {
    if constexpr (IsOptional<Member>::value) {
        assign(member.emplace(), value);
    } else if constexpr (std::is_array_v<Member>) {
        const auto& numbers = std::get<std::vector<double>>(value);
        std::transform(numbers.begin(), numbers.end(), std::begin(member),
                       [](double number) { return static_cast<std::decay_t<decltype(member[0])>>(number); });
    } else if constexpr (std::is_enum_v<Member>) {
        member = *from_name<Member>(std::get<std::string>(value));
    } else if constexpr (std::is_integral_v<Member>) {
        member = static_cast<Member>(std::get<std::int64_t>(value));
    } else {
        member = std::get<Member>(value);
    }
}

template <typename Type>
struct ClassOf;
template <typename Class, typename Type>
struct ClassOf<Type Class::*> {
    using type = Class;
};

/// The member at the end of a path of members: (object.*First).*Second and so on.
template <auto First, auto... Rest, typename Object>
auto& member_at(Object& object) {
    if constexpr (sizeof...(Rest) == 0) {
        return object.*First;
    } else {
        return member_at<Rest...>(object.*First);
    }
}

/// The row of a key that is kept in one member. Its default is what a new object has there.
template <auto First, auto... Rest>
auto row(SchemaKey schema) {
    using Object = typename ClassOf<decltype(First)>::type;
    ObjectKey<Object> key;
    key.value = [](const Object& object) { return value_of(member_at<First, Rest...>(object)); };
    key.set = [](Object& object, const KeyValue& value) { assign(member_at<First, Rest...>(object), value); };
    if (schema.fallback.empty()) {
        const std::optional<KeyValue> value = key.value(Object());
        if (value) schema.fallback = value_text(*value);
    }
    key.schema = std::move(schema);
    return key;
}

template <auto... Members>
auto whole_number(const char* path, const char* unit, const char* meaning, const IntegerRange& range) {
    return row<Members...>({path, KeyShape::kScalar, meaning, ValueRule::whole_numbers(range), unit});
}

template <auto... Members>
auto one_of(const char* path, const char* unit, const char* meaning, std::vector<std::int64_t> values,
            const char* what) {
    return row<Members...>(
        {path, KeyShape::kScalar, meaning, ValueRule::one_of(std::move(values), what), unit});
}

template <auto... Members>
auto number(const char* path, const char* unit, const char* meaning, const NumberRange& range) {
    return row<Members...>({path, KeyShape::kScalar, meaning, ValueRule::numbers(range), unit});
}

/// The row of an enumeration with names.
template <typename Enum, auto... Members>
auto choice(const char* path, const char* meaning) {
    return row<Members...>({path, KeyShape::kScalar, meaning, ValueRule::choice_of<Enum>()});
}

/// A key that must be given.
template <typename Object>
ObjectKey<Object> required(ObjectKey<Object> key) {
    key.required = true;
    key.schema.fallback = "required";
    return key;
}

/// A key with a default that depends on others; `words` describe it.
template <typename Object>
ObjectKey<Object> otherwise(ObjectKey<Object> key, const char* words,
                            KeyValue (*derived)(const Object&) = nullptr) {
    key.schema.fallback = words;
    key.derived = derived;
    return key;
}

}  // namespace object_key
}  // namespace metabuffer
