// The kernels compiled for AVX512.                                                                (kernel)
#define CREEP_KERNEL_NAMESPACE avx512
#include "core/dem/contact_kernel_lanes.h"
#include "core/dem/particle_kernel_lanes.h"

namespace creep::avx512 {

extern const Kernels kKernels;
const Kernels kKernels{"avx512", &contacts, &particles_in_lanes};

}  // namespace creep::avx512
