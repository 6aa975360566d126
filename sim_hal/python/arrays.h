/* Vectors as NumPy arrays without a copy, and values that may be missing as None. */
#ifndef SIM_HAL_PYTHON_ARRAYS_H
#define SIM_HAL_PYTHON_ARRAYS_H

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <optional>
#include <utility>
#include <vector>

namespace berth
{

/* The array owns the vector. */
template <typename T>
auto as_array(std::vector<T> values)
{
    auto *const kept = new std::vector<T>(std::move(values));
    const nanobind::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<T> *>(p); });
    return nanobind::cast(
        nanobind::ndarray<nanobind::numpy, T, nanobind::ndim<1>>(kept->data(), {kept->size()}, owner));
}

/* The bytes of records, for a structured array. */
template <typename T>
auto as_bytes(std::vector<T> records)
{
    auto *const kept = new std::vector<T>(std::move(records));
    const nanobind::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<T> *>(p); });
    return nanobind::cast(nanobind::ndarray<nanobind::numpy, std::uint8_t, nanobind::ndim<1>>(
        reinterpret_cast<std::uint8_t *>(kept->data()), {kept->size() * sizeof(T)}, owner));
}

template <typename T>
nanobind::object or_none(const std::optional<T> &value)
{
    return value ? nanobind::cast(*value) : nanobind::none();
}

} // namespace berth

#endif
