/*!
  \file sound_keys.cpp
  \brief The keys of an input with which nothing is wrong.
*/
#include <drivers/sound_keys.hpp>

#include <drivers/input.hpp>

#include <algorithm>

namespace Machpoint
{

SoundKeys::SoundKeys( const Json& resolved, const Json& written,
                      const std::string& file,
                      const std::vector<std::string>& errors )
{
    std::vector<std::string> known;
    for ( const auto all = inputParameters( 0 ); const auto& key : all.keys() )
        known.push_back( key.name );
    for ( const auto& item : resolved.items() )
        _keys.insert( item.key() );
    remove( errors, file + ": " );
    // Of a key that is misspelt the default is not what was meant.
    if ( written.is_object() )
        for ( const auto& item : written.items() )
            if ( !resolved.contains( item.key() ) )
                _keys.erase( nearest( item.key(), known ) );
}

void SoundKeys::remove( const std::vector<std::string>& messages,
                        const std::string& prefix )
{
    for ( const auto& message : messages )
        if ( const auto begin = prefix.size() + 1;
             message.starts_with( prefix + "/" ) )
            _keys.erase( message.substr(
                begin, message.find_first_of( "/:", begin ) - begin ) );
}

bool SoundKeys::have( const std::initializer_list<const char*> keys ) const
{
    return std::all_of( keys.begin(), keys.end(),
                        [&]( const char* key )
                        { return _keys.count( key ) > 0; } );
}

} // namespace Machpoint
