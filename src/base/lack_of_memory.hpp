#pragma once
#include <cstddef>
#include <exception>
#include <string>

namespace ringsplat {

/// An error's text where memory, or a thread, was asked for in vain: a string holds it without memory.
inline constexpr const char* lack_of_memory = "out of memory";

bool is_lack_of_memory(const std::exception& error);
/// Says it on stderr, with what to do, without taking memory.
void say_lack_of_memory() noexcept;
/// What say_lack_of_memory() writes behind the program's name, such as " [rank 3]".
void name_in_lack_of_memory(const std::string& rank);
/// Whether this process can have so much more address space.
bool has_address_space(std::size_t bytes);

/// Has what ends the program where nobody can catch it, such as a thread without memory, end it with
/// run_failed and a line when memory is what was lacking.
void prepare_for_lack_of_memory();

}  // namespace ringsplat
