" Vim syntax file
" Language: CSPm, with CSP-OZ classes
" Made by editors/generate.py

if exists("b:current_syntax")
  finish
endif

syntax case match
syntax iskeyword @,48-57,_,'
syntax keyword cspmKeyword assert channel datatype else endmodule exports external if include instance let module nametype print subtype then transparent within Timed
syntax keyword cspmKeyword channel chan method
syntax keyword cspmClass class end inherit visible chan method local_chan state init INIT op where Delta given reading view retrieve schema const lemma using forall exists exists1 lambda mu
syntax keyword cspmWord and or not
syntax keyword cspmConstant true false
syntax keyword cspmFunction BUFFER Bool CHAOS Char DIV Events False Int Inter Map Proc RUN SIGNAL_BUFFER SKIP STOP Seq Set True Union WAIT WEAK_BUFFER card chase chase_nocache concat dbisim deter diamond diff elem empty emptyMap error explicate extensions failure_watchdog head inter lazyenumerate lazynorm length loop mapDelete mapFromList mapLookup mapMember mapToList mapUpdate mapUpdateMultiple member model_compress mtransclose normal normalise null prioritise prioritise_nocache prioritisepo productions relational_image relational_inverse_image sbisim seq set show tail tau_loop_factor timed_priority trace_watchdog transpose union wbisim
syntax match cspmNumber "\<\d\+\%(\.\d\+\)\?\>"
syntax match cspmOperator "\[FD=\|\[VD=\|\[RD=\|\[OZ=\||\~|\||||\|\[T=\|\[F=\|\[V=\|\[R=\|\[|>\|<->\|\[|\||\]\|\[\[\|\]\]\|{|\||}\|(|\||)\|||\|\[\]\|\[>\|\[+\|+\]\|\/\\\|\/+\|+\\\||>\||\\\|<-\|->\|<=\|>=\|==\|!=\|@@"
syntax match cspmDefinition "^\s*\zs\h[[:alnum:]_']*\ze\s*\%(([^()]*)\s*\)*=[^=]"
syntax match cspmProperty ":\[[^]]*\%(\]\]\|\]\)"
syntax region cspmString start=+"+ skip=+\\.+ end=+"+ oneline
syntax region cspmComment start="--" end="$" keepend contains=cspmExpect,@Spell
syntax region cspmComment start="{-" end="-}" contains=cspmComment,@Spell
syntax match cspmExpect "expect:\s*\%(pass\|fail\|unknown\)" contained

highlight default link cspmKeyword Keyword
highlight default link cspmClass Structure
highlight default link cspmWord Operator
highlight default link cspmConstant Boolean
highlight default link cspmFunction Function
highlight default link cspmNumber Number
highlight default link cspmOperator Operator
highlight default link cspmDefinition Identifier
highlight default link cspmProperty Special
highlight default link cspmString String
highlight default link cspmComment Comment
highlight default link cspmExpect Todo

let b:current_syntax = "cspm"
