/*!
  \file large_pages.hpp
  \brief Layer 1: particles and nodes in large pages of memory.

  A kernel walks through as many places at once as particles have members. With
  pages of 4 KiB a processor has to look up where nearly each of them lies; with
  pages of 2 MiB it remembers. Linux gives these to who asks, where its setting
  is `madvise` or `always`
  (/sys/kernel/mm/transparent_hugepage/enabled).
*/
#ifndef MACHPOINT_LARGE_PAGES_HPP
#define MACHPOINT_LARGE_PAGES_HPP

namespace Machpoint
{

/*!
  \brief Asks for large pages for all that this program allocates on the host
  from now on and keeps: Kokkos' allocations of some MiB with a label of ours.

  What Cabana allocates is needed for one sort, and small pages come sooner.
  To be called after Kokkos was initialised; a tool that watches allocations
  (KOKKOS_TOOLS_LIBS) still sees them. Does nothing where kernels run on a GPU
  or the system is not Linux.
*/
void askForLargePages();

} // namespace Machpoint

#endif
