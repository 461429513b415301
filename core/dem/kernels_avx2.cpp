// The kernels compiled for AVX2.                                                                (kernel)
#define CREEP_KERNEL_NAMESPACE avx2
#include "core/dem/contact_kernel_lanes.h"
#include "core/dem/particle_kernel_lanes.h"

namespace creep::avx2 {

extern const Kernels kKernels;
const Kernels kKernels{"avx2", &contacts, &particles_in_lanes};

}  // namespace creep::avx2
