/*!
  \file Cabana_AtomicReference.hpp
  \brief What a slice with atomic access returns in place of a reference.
*/
#ifndef CABANA_ATOMICREFERENCE_HPP
#define CABANA_ATOMICREFERENCE_HPP

#include <Kokkos_Core.hpp>

namespace Cabana
{
namespace Impl
{

/*!
  \brief Stand-in for a T& whose every operation is one atomic operation.
  \tparam T A number.
*/
template <class T>
class AtomicReference
{
  public:
    //! Refer to a value in memory.
    KOKKOS_FORCEINLINE_FUNCTION explicit AtomicReference( T& value )
        : _value( &value )
    {
    }

    AtomicReference( const AtomicReference& ) = default;

    //! Read.
    KOKKOS_FORCEINLINE_FUNCTION operator T() const
    {
        return Kokkos::atomic_load( _value );
    }

    //! Write. Like all below returns the new value.
    KOKKOS_FORCEINLINE_FUNCTION T operator=( const T value ) const
    {
        Kokkos::atomic_store( _value, value );
        return value;
    }

    //! Copy the value that another one refers to, as references do.
    KOKKOS_FORCEINLINE_FUNCTION T operator=( const AtomicReference& other )
    {
        return *this = static_cast<T>( other );
    }

    //! Add.
    KOKKOS_FORCEINLINE_FUNCTION T operator+=( const T value ) const
    {
        return Kokkos::atomic_add_fetch( _value, value );
    }

    //! Subtract.
    KOKKOS_FORCEINLINE_FUNCTION T operator-=( const T value ) const
    {
        return Kokkos::atomic_sub_fetch( _value, value );
    }

    //! Multiply.
    KOKKOS_FORCEINLINE_FUNCTION T operator*=( const T value ) const
    {
        return Kokkos::atomic_mul_fetch( _value, value );
    }

    //! Divide.
    KOKKOS_FORCEINLINE_FUNCTION T operator/=( const T value ) const
    {
        return Kokkos::atomic_div_fetch( _value, value );
    }

    //! Increment.
    KOKKOS_FORCEINLINE_FUNCTION T operator++() const
    {
        return Kokkos::atomic_add_fetch( _value, T( 1 ) );
    }

    //! Decrement.
    KOKKOS_FORCEINLINE_FUNCTION T operator--() const
    {
        return Kokkos::atomic_sub_fetch( _value, T( 1 ) );
    }

    //! Increment; returns the old value.
    KOKKOS_FORCEINLINE_FUNCTION T operator++( int ) const
    {
        return Kokkos::atomic_fetch_add( _value, T( 1 ) );
    }

    //! Decrement; returns the old value.
    KOKKOS_FORCEINLINE_FUNCTION T operator--( int ) const
    {
        return Kokkos::atomic_fetch_sub( _value, T( 1 ) );
    }

  private:
    T* _value;
};

} // namespace Impl
} // namespace Cabana

#endif
