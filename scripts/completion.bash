# Tab completion for Bash: `source scripts/completion.bash`. Pass types and options of restirpg come from the program itself, the
# Python programs answer through argcomplete.
_restirpg()
{
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} program=${COMP_WORDS[0]} words=
    case $before in
        --scene) COMPREPLY=($(compgen -f -X '!*.@(glb|gltf)' -- "$word") $(compgen -d -- "$word")); return ;;
        --output) words="image variance invalid albedo normal depth" ;;
        --backend) words="software rayquery" ;;
        describe) words=$("$program" describe 2>/dev/null | sed -n 's/^\([A-Za-z]*\): .*/\1/p') ;;
        graph | render) COMPREPLY=($(compgen -f -X '!*.@(py|json)' -- "$word") $(compgen -d -- "$word")); return ;;
        *)
            if ((COMP_CWORD == 1)); then
                words="render describe graph devices --help"
            elif [[ $word == -* ]]; then
                words=$("$program" "${COMP_WORDS[1]}" --help 2>/dev/null | grep -oE -- '--?[a-z][a-z-]*')
            else
                COMPREPLY=($(compgen -f -- "$word"))
                return
            fi ;;
    esac
    COMPREPLY=($(compgen -W "$words" -- "$word"))
}
complete -o filenames -F _restirpg restirpg build/bin/restirpg
for _program in compare make_scenes reproduce see_guide; do
    command -v register-python-argcomplete >/dev/null && eval "$(register-python-argcomplete "$_program.py" "scripts/$_program.py")"
done
unset _program
