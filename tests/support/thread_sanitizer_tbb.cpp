// SPDX-License-Identifier: MIT
// Debian's oneTBB library is not compiled for the thread sanitizer, which therefore does not see that a task
// begins after it was spawned and that a wait ends after its tasks, and calls both a race. Linked into the
// tests of the thread sanitizer build, these functions replace the library's entry points, report that order
// to the sanitizer, and call the library. Races in our own code are reported as ever.
#include <dlfcn.h>
#include <oneapi/tbb/detail/_small_object_pool.h>
#include <oneapi/tbb/detail/_task.h>
#include <sanitizer/tsan_interface.h>

#include <new>

namespace tbb::detail {
namespace {

template <typename Function>
Function* library_function(const char* mangled_name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, mangled_name));
}

/// Stands in for a spawned task until a thread takes it up.
class SpawnedTask final : public d1::task {
 public:
  static SpawnedTask& announce(d1::task& spawned) {
    auto* const stand_in = new SpawnedTask(spawned);
    __tsan_release(stand_in);
    return *stand_in;
  }

  d1::task* execute(d1::execution_data& data) override {
    __tsan_acquire(this);
    d1::task* const next = spawned_->execute(data);
    // Not reached if the task throws: the library then calls cancel.
    delete this;
    return next;
  }

  d1::task* cancel(d1::execution_data& data) override {
    __tsan_acquire(this);
    d1::task* const next = spawned_->cancel(data);
    delete this;
    return next;
  }

 private:
  explicit SpawnedTask(d1::task& spawned) : spawned_(&spawned) {}

  d1::task* spawned_;
};

/// Tasks say that they are done by counting down inside the wait context, in code the sanitizer sees. Its
/// destructor takes that in, so that it also holds when the wait throws.
struct TasksDone {
  d1::wait_context& context;
  ~TasksDone() {
    auto* const bytes = reinterpret_cast<char*>(&context);
    for (std::size_t i = 0; i < sizeof(context); i += 8) __tsan_acquire(bytes + i);
  }
};

}  // namespace

namespace r1 {

void spawn(d1::task& task, d1::task_group_context& context) {
  static auto* const spawn_in_library = library_function<void(d1::task&, d1::task_group_context&)>(
      "_ZN3tbb6detail2r15spawnERNS0_2d14taskERNS2_18task_group_contextE");
  spawn_in_library(SpawnedTask::announce(task), context);
}

void spawn(d1::task& task, d1::task_group_context& context, d1::slot_id slot) {
  static auto* const spawn_in_library =
      library_function<void(d1::task&, d1::task_group_context&, d1::slot_id)>(
          "_ZN3tbb6detail2r15spawnERNS0_2d14taskERNS2_18task_group_contextEt");
  spawn_in_library(SpawnedTask::announce(task), context, slot);
}

void execute_and_wait(d1::task& task, d1::task_group_context& task_context, d1::wait_context& wait_context,
                      d1::task_group_context& wait_group_context) {
  static auto* const execute_in_library = library_function<void(d1::task&, d1::task_group_context&,
                                                                d1::wait_context&, d1::task_group_context&)>(
      "_ZN3tbb6detail2r116execute_and_waitERNS0_2d14taskERNS2_18task_group_contextERNS2_12wait_contextES6_");
  const TasksDone done{wait_context};
  execute_in_library(task, task_context, wait_context, wait_group_context);
}

void wait(d1::wait_context& wait_context, d1::task_group_context& context) {
  static auto* const wait_in_library = library_function<void(d1::wait_context&, d1::task_group_context&)>(
      "_ZN3tbb6detail2r14waitERNS0_2d112wait_contextERNS2_18task_group_contextE");
  const TasksDone done{wait_context};
  wait_in_library(wait_context, context);
}

// The library hands memory of one task to the next without the sanitizer's knowledge; the heap does so with
// it.
void* allocate(d1::small_object_pool*& pool, std::size_t size) {
  // The caller only hands the pool back to deallocate, which here does not use it.
  static char no_pool;
  pool = reinterpret_cast<d1::small_object_pool*>(&no_pool);
  return ::operator new(size);
}
void* allocate(d1::small_object_pool*& pool, std::size_t size, const d1::execution_data&) {
  return allocate(pool, size);
}
void deallocate(d1::small_object_pool&, void* memory, std::size_t) {
  ::operator delete(memory);
}
void deallocate(d1::small_object_pool&, void* memory, std::size_t, const d1::execution_data&) {
  ::operator delete(memory);
}

}  // namespace r1
}  // namespace tbb::detail
